//! `[[volume]]`: a file, files, or a generator.

use super::shape::{Bounds, Key, Presence, Shape, Table};
use crate::codec::SettingKind;
use crate::pipeline::ByteOrder;
use crate::pipeline::Known;
use crate::volume::{SampleType, StoredType};

/// Keys of a headerless file, each with the keys that it requires.
const RAW_NEEDS: [(&str, &[&str]); 6] = [
    ("dims", &["dtype"]),
    ("dtype", &["dims"]),
    ("frames", &["dims", "dtype"]),
    ("channels", &["dims", "dtype"]),
    ("byte_order", &["dims", "dtype"]),
    ("skip_bytes", &["dims", "dtype"]),
];

/// The three kinds of volumes. One key identifies each kind.
pub(super) fn tables(known: &Known<'_>) -> Vec<(String, Table)> {
    let file = Key::required(
        "file",
        Shape::Path,
        "A file of any format that `docs/user/inputs.md` lists, a folder of slices, or a pattern like `step*.raw` whose files \
         are frames; `$NAME` stands for an environment variable",
    );
    let list = Shape::List { item: Box::new(Shape::Path), least: 1, most: None };
    let files = Key::required("files", list, "Files, folders or patterns whose frames follow each other");
    let generators = known.generators.iter().map(|&name| (name.to_owned(), String::new())).collect();
    let generate = Key::required(
        "generate",
        Shape::Words(generators),
        "A formula; random ones depend on the experiment's seed",
    );
    vec![
        ("file".to_owned(), from_files("A volume from a file.", file)),
        ("files".to_owned(), from_files("A volume from several files.", files)),
        ("generate".to_owned(), generated(generate)),
    ]
}

fn name() -> Key {
    let doc = "Name in records and files, unique even without regard to case";
    Key::required("name", Shape::Name, doc)
}

fn dims() -> Shape {
    let axis = || Shape::Integer { min: 1, max: i64::from(u32::MAX) };
    Shape::Tuple(vec![axis(), axis(), axis()])
}

fn frames() -> Shape {
    Shape::Integer { min: 1, max: i64::from(u32::MAX) }
}

fn words<const N: usize>(names: [&str; N]) -> Shape {
    Shape::Words(names.map(|name| (name.to_owned(), String::new())).into())
}

fn from_files(doc: &str, source: Key) -> Table {
    let headerless = Presence::Absent("the file's header says it");
    let length = || Shape::Number(Bounds::POSITIVE);
    let orders = [ByteOrder::Little, ByteOrder::Big].map(ByteOrder::name);
    let channels = Shape::Setting(SettingKind::OneOf(&[1, 3]));
    let keys = vec![
        name(),
        source,
        Key::new("dims", dims(), headerless, "Size along x, y, z of a headerless file, with `dtype`")
            .unit("voxels"),
        Key::new(
            "dtype",
            words(StoredType::ALL.map(StoredType::name)),
            Presence::Absent("the file's header says it"),
            "Number type of a headerless file, with `dims`",
        ),
        Key::with_default("frames", frames(), "1", "Time steps in a headerless file, one after the other"),
        Key::with_default(
            "channels",
            channels,
            "1",
            "Values per voxel of a headerless file, side by side: 1 (scalar) or 3 (RGB)",
        ),
        Key::with_default("byte_order", words(orders), "\"little\"", "Byte order of a headerless file"),
        Key::with_default(
            "skip_bytes",
            Shape::Integer { min: 0, max: i64::MAX },
            "0",
            "Bytes before the voxels of a headerless file",
        )
        .unit("bytes"),
        Key::new(
            "spacing",
            Shape::Tuple(vec![length(), length(), length()]),
            Presence::Absent("what the file says; 1 where it is silent"),
            "Distance between voxel centres along x, y, z, in any unit of length",
        ),
    ];
    Table { needs: RAW_NEEDS.to_vec(), ..Table::new(doc, keys) }
}

fn generated(source: Key) -> Table {
    let keys = vec![
        name(),
        source,
        Key::with_default("dims", dims(), "[64, 64, 64]", "Size along x, y, z").unit("voxels"),
        Key::with_default("dtype", words(SampleType::ALL.map(SampleType::name)), "\"u8\"", "Number type"),
        Key::with_default("frames", frames(), "1", "Time steps"),
    ];
    Table::new("A volume from a formula. Its spacing is 1.", keys)
}
