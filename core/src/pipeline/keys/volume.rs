//! `[[volume]]`: a file, files, or a generator.

use super::shape::{Bounds, Key, Presence, Shape, Table};
use crate::codec::SettingKind;
use crate::pipeline::ByteOrder;
use crate::volume::{SampleType, StoredType};

/// Default number of voxels along each axis of a generated volume.
pub(in crate::pipeline) const DEFAULT_EDGE: u32 = 64;

/// Keys of a headerless file, each with the keys that it requires.
pub(in crate::pipeline) const RAW_NEEDS: [(&str, &[&str]); 6] = [
    ("dims", &["dtype"]),
    ("dtype", &["dims"]),
    ("frames", &["dims", "dtype"]),
    ("channels", &["dims", "dtype"]),
    ("byte_order", &["dims", "dtype"]),
    ("skip_bytes", &["dims", "dtype"]),
];

/// The names of all keys that a volume may have: its name, the keys that say where it comes from, and the others.
pub(in crate::pipeline) fn names() -> Vec<String> {
    let tables = tables(&[]);
    let (origins, others): (Vec<_>, Vec<_>) = tables.iter().map(|(_, table)| table.keys.split_at(2)).unzip();
    let mut names: Vec<String> = Vec::new();
    for key in origins.into_iter().chain(others).flatten() {
        if !names.contains(&key.name) {
            names.push(key.name.clone());
        }
    }
    names
}

/// The names of those keys that describe a file, and mean nothing where a volume is generated.
pub(in crate::pipeline) fn of_files_alone() -> Vec<String> {
    let generated = generated(origin_generate(&[]));
    let described = from_files("", origin_file()).keys.into_iter().skip(2).map(|key| key.name);
    described.filter(|name| !generated.names().contains(&name.as_str())).collect()
}

/// The three kinds of volumes, by the key that tells them apart. In each, the first key names the volume, and the second
/// says where it comes from.
pub(super) fn tables(generators: &[&str]) -> Vec<(String, Table)> {
    let list = Shape::List { item: Box::new(Shape::Path), least: 1, most: None };
    let files = Key::required("files", list, "Files, folders or patterns whose frames follow each other");
    vec![
        ("file".to_owned(), from_files("A volume from a file.", origin_file())),
        ("files".to_owned(), from_files("A volume from several files.", files)),
        ("generate".to_owned(), generated(origin_generate(generators))),
    ]
}

fn origin_file() -> Key {
    let doc = "A file of any format that `docs/user/inputs.md` lists, a folder of slices, or a pattern like `step*.raw` whose \
               files are frames; `$NAME` stands for an environment variable";
    Key::required("file", Shape::Path, doc)
}

fn origin_generate(generators: &[&str]) -> Key {
    let generators = generators.iter().map(|&name| (name.to_owned(), String::new())).collect();
    Key::required(
        "generate",
        Shape::Words(generators),
        "A formula; random ones depend on the experiment's seed",
    )
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
        Key::with_default("dims", dims(), format!("{:?}", [DEFAULT_EDGE; 3]), "Size along x, y, z")
            .unit("voxels"),
        Key::with_default("dtype", words(SampleType::ALL.map(SampleType::name)), "\"u8\"", "Number type"),
        Key::with_default("frames", frames(), "1", "Time steps"),
    ];
    Table::new("A volume from a formula. Its spacing is 1.", keys)
}
