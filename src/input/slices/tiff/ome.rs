//! The OME-XML of a description: <https://docs.openmicroscopy.org/ome-model/latest/ome-tiff/specification.html>.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::super::Slice;
use super::promise::{Promise, Spacing};

/// Whether the root element is OME's; it stands behind a declaration and comments.
pub(super) fn looks_like(text: &str) -> bool {
    let mut xml = Reader::from_str(text);
    loop {
        match xml.read_event() {
            Ok(Event::Start(start) | Event::Empty(start)) => return local_name(&start) == "OME",
            Ok(Event::Eof) | Err(_) => return text.contains("<OME"),
            Ok(_) => {}
        }
    }
}

fn local_name(start: &BytesStart<'_>) -> String {
    let name = start.name().as_ref().to_owned();
    name.rsplit(':').next().unwrap_or_default().to_owned()
}

/// The promise of the description's one image.
///
/// # Errors
/// A sentence, when there are several images, or none, or their axes are not said.
pub(super) fn read(text: &str, page: Slice) -> Result<Promise, String> {
    let mut xml = Reader::from_str(text);
    let mut promise = Promise::new("OME");
    let mut images = 0;
    let mut channels = 0;
    loop {
        let event = xml.read_event().map_err(|e| format!("its OME-XML is damaged ({e})"))?;
        let (Event::Start(start) | Event::Empty(start)) = event else {
            match event {
                Event::Eof => break,
                _ => continue,
            }
        };
        let attribute = |name: &str| attribute(&start, name);
        match local_name(&start).as_str() {
            "Pixels" => {
                images += 1;
                let size = |name: &str| match attribute(name).map(|n| n.trim().parse::<u64>()) {
                    Some(Ok(n)) if n > 0 => Ok(n),
                    _ => Err(format!("its OME-XML has no usable `{name}`")),
                };
                let (z, t) = (size("SizeZ")?, size("SizeT")?);
                channels = size("SizeC")?;
                (promise.slices, promise.frames) = (Some(z), t);
                promise.spacing = spacing(&attribute)?;
            }
            "BinaryOnly" => {
                return Err("its OME-XML puts the axes into another file".to_owned());
            }
            "UUID" => promise.files.extend(attribute("FileName")),
            _ => {}
        }
    }
    if images != 1 {
        return Err(format!("OME promises {images} images"));
    }
    // Channels that lie side by side in a pixel are not in pages of their own.
    let of_pixel = u64::from(page.channels);
    promise.channels = if channels.is_multiple_of(of_pixel) { channels / of_pixel } else { channels };
    let slices = promise.slices.unwrap_or(1);
    promise.pages = Some(slices.saturating_mul(promise.frames).saturating_mul(promise.channels));
    Ok(promise)
}

fn attribute(start: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = start.attributes().flatten().find(|a| a.key.as_ref() == name)?;
    Some(found.value.into_owned())
}

/// `PhysicalSizeX`, `Y` and `Z`, where all are there.
fn spacing(attribute: &dyn Fn(&str) -> Option<String>) -> Result<Spacing, String> {
    let mut spacing = [0.0; 3];
    let mut units = Vec::new();
    for (to, axis) in spacing.iter_mut().zip(["X", "Y", "Z"]) {
        let length = attribute(&format!("PhysicalSize{axis}")).and_then(|n| n.trim().parse::<f64>().ok());
        let Some(length) = length.filter(|n| n.is_finite() && *n > 0.0) else { return Ok(Spacing::Unknown) };
        *to = length;
        units.push(attribute(&format!("PhysicalSize{axis}Unit")).unwrap_or_else(|| "µm".to_owned()));
    }
    if units.iter().any(|unit| *unit != units[0]) {
        return Err(format!("its OME-XML has spacings in several units: {}", units.join(", ")));
    }
    Ok(Spacing::Is(spacing))
}

#[cfg(test)]
mod tests {
    use cvr_core::volume::StoredType;

    use super::super::description;
    use super::*;

    const PAGE: Slice = Slice { width: 11, height: 7, channels: 1, stored: StoredType::U16 };

    fn xml(pixels: &str, inside: &str) -> String {
        let namespace = "http://www.openmicroscopy.org/Schemas/OME/2016-06";
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?><!-- a > b --><OME xmlns=\"{namespace}\"><Image ID=\"Image:0\">\
             <Pixels SizeX=\"11\" SizeY=\"7\" {pixels}>{inside}</Pixels></Image></OME>"
        )
    }

    #[test]
    fn sizes_and_spacings_are_read() {
        let sizes = "SizeZ=\"6\" SizeC=\"2\" SizeT=\"3\" PhysicalSizeX=\"0.5\" PhysicalSizeY=\"1.25\" PhysicalSizeZ=\"2\"";
        let found = description::read(&xml(sizes, "<TiffData IFD=\"0\"/>"), PAGE).unwrap().unwrap();
        assert_eq!((found.pages, found.slices, found.channels, found.frames), (Some(36), Some(6), 2, 3));
        assert_eq!(found.spacing, Spacing::Is([0.5, 1.25, 2.0]));
        assert_eq!(found.words(), "3 frames of 2 channels of 6 slices");
        let colours = "SizeZ=\"6\" SizeC=\"3\" SizeT=\"1\"";
        let found = read(&xml(colours, ""), Slice { channels: 3, ..PAGE }).unwrap();
        assert_eq!((found.pages, found.channels, found.spacing), (Some(6), 1, Spacing::Unknown));
        let files = "<TiffData><UUID FileName=\"a.tif\">x</UUID></TiffData><TiffData><UUID FileName=\"b.tif\"/></TiffData>";
        assert_eq!(read(&xml(colours, files), PAGE).unwrap().files.len(), 2);
    }

    #[test]
    fn what_cannot_be_told_is_refused() {
        let one = "SizeZ=\"6\" SizeC=\"1\" SizeT=\"1\"";
        let two = xml(one, "")
            .replace("</OME>", "<Image><Pixels SizeZ=\"6\" SizeC=\"1\" SizeT=\"1\"/></Image></OME>");
        let units = format!(
            "{one} PhysicalSizeX=\"1\" PhysicalSizeY=\"1\" PhysicalSizeZ=\"1\" PhysicalSizeZUnit=\"nm\""
        );
        for (text, words) in [
            (two, "2 images"),
            (xml("SizeZ=\"6\" SizeC=\"1\"", ""), "no usable `SizeT`"),
            (xml("SizeZ=\"0\" SizeC=\"1\" SizeT=\"1\"", ""), "no usable `SizeZ`"),
            (xml(one, "").replace("</Pixels>", ""), "damaged"),
            (xml(&units, ""), "several units: µm, µm, nm"),
            ("<OME><BinaryOnly MetadataFile=\"a.companion.ome\"/></OME>".to_owned(), "another file"),
        ] {
            let error = description::read(&text, PAGE).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
        assert_eq!(description::read("<svg></svg>", PAGE), Ok(None));
    }
}
