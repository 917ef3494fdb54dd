//! TIFF files that promise more than their pages, or other things than slices.

use cvr_core::volume::{BrickSource as _, Samples};

use super::Folder;
use super::tiff_files::{Page, tiff};
use crate::input::open;

/// So many pages, the first with this description.
fn stack(pages: u8, description: &str) -> Vec<Page> {
    let mut stack: Vec<Page> = (0..pages).map(|n| Page::small(n * 6)).collect();
    stack[0].description = Some(description.as_bytes().to_vec());
    stack
}

fn refusal(pages: &[Page]) -> String {
    Folder::new().refusal("v.tif", "", &tiff(pages).0)
}

fn ome(sizes: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image><Pixels \
         SizeX=\"3\" SizeY=\"2\" {sizes}/></Image></OME>"
    )
}

#[test]
fn stacks_that_hold_what_they_promise_are_read() {
    let folder = Folder::new();
    let due = Samples::U8((0..36).collect());
    let plain = (0..6).map(|n| Page::small(n * 6)).collect::<Vec<_>>();
    let each = |text: &str| plain.iter().cloned().map(|page| page.described(text)).collect::<Vec<_>>();
    for pages in [
        plain.clone(),
        stack(6, "a letter"),
        stack(6, "ImageJ=1.53t\nimages=6\nslices=6\n"),
        stack(6, "ImageJ=1.53t\nimages=6\n"),
        stack(6, "ImageJ=1.53t\n"),
        stack(6, "{\"shape\": [6, 2, 3]}"),
        stack(6, "{\"axes\": \"ZYX\", \"shape\": [6, 2, 3]}"),
        stack(6, "shape=(6, 2, 3)"),
        stack(6, &ome("SizeZ=\"6\" SizeC=\"1\" SizeT=\"1\"")),
        // Written page by page, or with the description on each of them.
        each("{\"shape\": [2, 3]}"),
        each("ImageJ=1.53t\nimages=6\nslices=6\n"),
    ] {
        let volume = open(&folder.write("v.tif", "", &tiff(&pages).0)).unwrap();
        assert_eq!(volume.samples(), &due, "{:?}", pages[0].description);
        assert_eq!(volume.layout().extent.to_array(), [3, 2, 6]);
        assert_eq!(volume.layout().spacing, [1.0; 3]);
    }
}

#[test]
fn what_is_promised_and_is_not_read_is_refused() {
    for (pages, words) in [
        (
            stack(1, "ImageJ=1.53t\nimages=6\nslices=6\n"),
            &["ImageJ promises 6 slices, and 1 page is there", "OME-TIFF"][..],
        ),
        (stack(1, "ImageJ=1.53t\nimages=6\n"), &["ImageJ promises 6 images, and 1 page is there"]),
        (stack(5, "ImageJ=1.53t\nimages=6\nslices=6\n"), &["6 slices, and 5 pages are there"]),
        (
            stack(6, "ImageJ=1.53t\nimages=6\nslices=3\nchannels=2\n"),
            &["2 channels of 3 slices (ImageJ)", "file of its own"],
        ),
        (stack(6, "ImageJ=1.53t\nimages=6\nframes=6\n"), &["6 frames (ImageJ)"]),
        (stack(6, "ImageJ=1.53t\nimages=6\nslices=5\n"), &["contradict"]),
        (
            stack(1, "{\"shape\": [6, 2, 3], \"truncated\": true}"),
            &["tifffile promises 6 slices, and 1 page is there"],
        ),
        (stack(6, "{\"shape\": [2, 3, 2, 3]}"), &["2×3×2×3"]),
        (stack(6, "{\"axes\": \"TYX\", \"shape\": [6, 2, 3]}"), &["6 frames"]),
        (stack(6, "{\"shape\": [6, 4, 3]}"), &["6×4×3", "3×2 pixels"]),
        (stack(6, &ome("SizeZ=\"3\" SizeC=\"2\" SizeT=\"1\"")), &["2 channels of 3 slices (OME)"]),
        (stack(6, &ome("SizeZ=\"1\" SizeC=\"1\" SizeT=\"6\"")), &["6 frames of 1 slice (OME)"]),
        (
            stack(1, &ome("SizeZ=\"6\" SizeC=\"1\" SizeT=\"1\"")),
            &["OME promises 6 slices, and 1 page is there"],
        ),
        (stack(6, "<OME><BinaryOnly MetadataFile=\"a.companion.ome\"/></OME>"), &["another file"]),
    ] {
        let message = refusal(&pages);
        for word in words.iter().chain([&"v.tif"]) {
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    }
    let two = [stack(3, "{\"shape\": [3, 2, 3]}"), stack(3, "{\"shape\": [3, 2, 3]}")].concat();
    assert!(refusal(&two).contains("2 series of pages"), "{}", refusal(&two));
    let with = |tag, value| {
        let mut pages = stack(2, "");
        pages[1].more.push((tag, value));
        refusal(&pages)
    };
    for (tag, value, words) in [
        (254, 1, "reduced copy or a mask"),
        (254, 4, "reduced copy or a mask"),
        (32997, 2, "2 slices (`ImageDepth`)"),
        (33629, 5, "MetaMorph"),
        (34412, 5, "Zeiss LSM"),
    ] {
        let message = with(tag, value);
        assert!(message.contains("page 2") && message.contains(words), "{message}");
    }
    let folder = Folder::new();
    let mut pages = stack(2, "");
    pages[1].more.push((254, 2));
    assert!(open(&folder.write("v.tif", "", &tiff(&pages).0)).is_ok(), "a page of several is no copy");
}

#[test]
fn spacing_is_that_of_imagej_or_ome() {
    let folder = Folder::new();
    let spacing = |pages: &[Page]| open(&folder.write("v.tif", "", &tiff(pages).0)).unwrap().layout().spacing;
    let mut imagej = stack(2, "ImageJ=1.53t\nimages=2\nslices=2\nspacing=2.5\nunit=um\n");
    imagej[0].resolution = Some([[2, 1], [4, 5]]);
    assert_eq!(spacing(&imagej), [0.5, 1.25, 2.5]);
    // Bytes that are not UTF-8, from before ImageJ escaped them.
    imagej[0].description = Some(b"ImageJ=1.43\nimages=2\nunit=\xb5m\n".to_vec());
    assert_eq!(spacing(&imagej), [0.5, 1.25, 1.0]);
    imagej[0].resolution = Some([[0, 1], [4, 5]]);
    assert_eq!(spacing(&imagej), [1.0; 3]);
    let sizes = "SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\" PhysicalSizeX=\"0.5\" PhysicalSizeY=\"1.25\" PhysicalSizeZ=\"2\"";
    assert_eq!(spacing(&stack(2, &ome(sizes))), [0.5, 1.25, 2.0]);
}

#[test]
fn files_that_promise_slices_together_are_read_together() {
    let folder = Folder::new();
    let files =
        "<TiffData><UUID FileName=\"a1.tif\"/></TiffData><TiffData><UUID FileName=\"a2.tif\"/></TiffData>";
    let text = ome("SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\"")
        .replace("/></Image>", &format!(">{files}</Pixels></Image>"));
    let slices = folder.path("slices");
    std::fs::create_dir(&slices).unwrap();
    for n in 1..=2 {
        std::fs::write(slices.join(format!("a{n}.tif")), tiff(&[Page::small(n * 6).described(&text)]).0)
            .unwrap();
    }
    assert_eq!(open(&slices).unwrap().samples(), &Samples::U8((6..18).collect()));
    let message = folder.message(open(&slices.join("a1.tif")));
    assert!(message.contains("2 slices are promised in several files, and 1 are there"), "{message}");
    std::fs::remove_file(slices.join("a2.tif")).unwrap();
    assert!(folder.message(open(&slices)).contains("give the folder that holds all of them"));
}
