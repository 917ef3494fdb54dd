//! Limits on the number of cells.

use super::*;
use crate::pipeline::{Capabilities, Experiment, resolve};

/// The example with one codec. Its block and index bits are lists of these lengths.
fn sweep(blocks: u32, bits: usize) -> String {
    let blocks: Vec<String> = (0..blocks).map(|i| format!("\"{}x{}x2\"", i % 64 + 1, i / 64 + 1)).collect();
    let bits = &["1", "2", "4", "8"][..bits];
    let lists = format!("block = [{}]\nindex_bits = [{}]", blocks.join(", "), bits.join(", "));
    let own = "block = [4, 8, \"8x8x4\"]             # a list is a sweep; an integer is a cube\nindex_bits = [2, 4]";
    edited(own, &lists)
}

#[test]
fn a_product_is_found_without_making_it() {
    let one = read(&sweep(1, 1), &["pipeline.site=inline", "pipeline.filter=linear"]).unwrap();
    // raw and s3dc, one volume, one scene.
    assert_eq!(one.combinations(), 2);
    let many = read(&sweep(50, 3), &["pipeline.site=inline", "pipeline.filter=linear"]).unwrap();
    assert_eq!(many.combinations(), 1 + 150);
    let resolution = resolve(&many, &known(&registry()), &Capabilities::default());
    assert_eq!(resolution.cells.len() + resolution.refused.len(), 151);
    // 2^70 and more: no sum or product overflows.
    let mut huge = many;
    huge.codecs = vec![huge.codecs[1].clone(); 3];
    for codec in &mut huge.codecs {
        let long = codec.sweeps[0].clone();
        codec.sweeps.extend(std::iter::repeat_n(long, 40));
    }
    assert_eq!(huge.combinations(), u128::MAX);
    assert!(huge.check_size().is_err());
}

#[test]
fn more_cells_than_are_allowed_are_refused_with_the_way_out() {
    let cells = |set: &[&str]| read(&sweep(50, 4), set).map(|e| e.combinations());
    let all = cells(&[]).unwrap();
    let limit = |n: u128| format!("experiment.max_cells={n}");
    assert_eq!(cells(&[&limit(all)]), Ok(all));
    insta::assert_snapshot!(cells(&[&limit(all - 1)]).unwrap_err(), @r"
    error: the experiment has 804 cells, and 803 are allowed
      ┌─ --set:1:22
      │
    1 │ experiment.max_cells=803
      │                      ^^^ as this says
      │
      = they are volumes × settings of codecs × scenes × renderers × sites × filters × skipping × stages × resolutions
      = shorten a list, or write a larger number as `max_cells` of `[experiment]`; in place of it, `--set experiment.max_cells=N`
    ");
    // The configuration has no limit of its own, so the error shows the section.
    let scenes: String =
        (0..4).map(|i| format!("[[scene]]\nname = \"s{i}\"\ntransfer_function = \"ramp\"\n")).collect();
    let refused = read(&format!("{}{scenes}", sweep(2048, 4)), &[]).unwrap_err();
    // One volume, 1 + 2048 × 4 settings, five scenes, two sites and filters.
    let expected = format!("has {} cells, and {} are allowed", (1 + 2048 * 4) * 5 * 4, Experiment::MAX_CELLS);
    assert!(refused.contains(&expected) && refused.contains("max_cells"), "{refused}");
}

#[test]
fn settings_of_a_renderer_are_bounded_before_they_are_multiplied() {
    let layers = "pipeline.layers=[1, 2, 3, 4, 5, 6]";
    let set = [
        "pipeline.renderer=slicing",
        layers,
        "pipeline.geometry=[\"axis\", \"planes\"]",
        "experiment.max_cells=11",
    ];
    let refused = read(EXAMPLE, &set).unwrap_err().to_string();
    assert!(refused.contains("renderer `slicing` alone make 12 cells, and 11 are allowed"), "{refused}");
}

#[test]
fn equal_values_count_once_and_a_note_says_so() {
    let set = ["codec.s3dc.index_bits=[2, 4, 2, 2]", "codec.s3dc.block=[4, \"4x4x4\"]"];
    let experiment = read(EXAMPLE, &set).unwrap();
    let counts: Vec<usize> = experiment.codecs[1].sweeps.iter().map(|s| s.values.len()).collect();
    assert_eq!(counts, [1, 2]);
    insta::assert_snapshot!(experiment.notes.join("\n"), @r"
    --set:1: `block` of codec `s3dc` lists `4` again; equal values count once
    --set:1: `index_bits` of codec `s3dc` lists `2` and 1 more again; equal values count once
    ");
    assert_eq!(read(EXAMPLE, &[]).unwrap().notes, [""; 0]);
    let again = "pipeline.geometry=[\"axis\", \"planes\", \"axis\"]";
    let notes = read(EXAMPLE, &["pipeline.renderer=slicing", again]).unwrap().notes;
    assert_eq!(
        notes,
        ["--set:1: `geometry` of renderer `slicing` lists `axis` again; equal values count once"]
    );
}
