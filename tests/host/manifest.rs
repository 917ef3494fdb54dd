//! Every real volume opens as its manifest says, and has the same samples as in other software. Without `CVR_DATA`, or
//! without that software, a test prints one line.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use cvr::input::{InputVolume, RawLayout, read};
use cvr_core::pipeline::ByteOrder;
use cvr_core::volume::{BrickSource as _, Extent, FrameIndex, StoredType};
use sha2::{Digest as _, Sha256};

/// One volume of the manifest.
#[derive(serde::Deserialize)]
struct Entry {
    name: String,
    file: PathBuf,
    format: String,
    dims: Vec<u32>,
    dtype: String,
    endian: Option<String>,
    spacing: [f64; 3],
}

#[derive(serde::Deserialize)]
struct Manifest {
    volume: Vec<Entry>,
}

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("CVR_DATA").map(PathBuf::from);
    let manifest = folder.as_ref().map(|f| f.join("MANIFEST.toml"));
    if !manifest.is_some_and(|m| m.is_file()) {
        println!(
            "skipped: no volume of the manifest is read, because CVR_DATA names no folder with a MANIFEST.toml"
        );
        return None;
    }
    folder
}

fn entries(folder: &Path) -> Vec<Entry> {
    let text = std::fs::read_to_string(folder.join("MANIFEST.toml")).unwrap();
    toml::from_str::<Manifest>(&text).unwrap().volume
}

impl Entry {
    /// Number type and channels.
    fn samples(&self) -> (StoredType, u32) {
        match self.dtype.as_str() {
            "rgb24" => (StoredType::U8, 3),
            name => {
                let short = name.replace("uint", "u").replace("int", "i").replace("float", "f");
                (StoredType::from_name(&short).unwrap(), 1)
            }
        }
    }

    fn open(&self, folder: &Path) -> InputVolume {
        let [x, y, z] = self.dims[..3] else { panic!("{} has no three dimensions", self.name) };
        let raw = (self.format == "raw").then(|| RawLayout {
            byte_order: if self.endian.as_deref() == Some("big") {
                ByteOrder::Big
            } else {
                ByteOrder::Little
            },
            spacing: self.spacing,
            ..RawLayout::new(Extent::new(x, y, z).unwrap(), self.samples().0)
        });
        read(&[folder.join(&self.file)], raw.as_ref(), None).unwrap_or_else(|e| panic!("{}: {e}", self.name))
    }
}

/// Headers round numbers that the manifest has from other sources.
fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * b)
}

#[test]
fn every_volume_opens_as_the_manifest_says() {
    let Some(folder) = folder() else { return };
    let entries = entries(&folder);
    assert!(!entries.is_empty());
    for entry in entries {
        let input = entry.open(&folder);
        let layout = input.volume.layout();
        let (stored, channels) = entry.samples();
        assert_eq!(layout.extent.to_array(), entry.dims[..3], "{}", entry.name);
        let frames = entry.dims.get(3).copied().unwrap_or(1);
        assert_eq!((layout.channels, layout.frames), (channels, frames), "{}", entry.name);
        assert_eq!((input.stored, input.rounded), (stored, 0), "{}", entry.name);
        assert!(near(layout.spacing, entry.spacing), "{}: {:?}", entry.name, layout.spacing);
    }
}

/// The other reader's result for one volume.
#[derive(serde::Deserialize)]
struct Facts {
    name: String,
    dims: [u32; 3],
    channels: u32,
    frames: u32,
    spacing: [f64; 3],
    sha256: String,
    min: f64,
    max: f64,
    sum: f64,
}

/// The differences between a volume and the other reader's result.
fn differences(input: &InputVolume, facts: &Facts) -> Vec<String> {
    let layout = input.volume.layout();
    let mut found = Vec::new();
    let shape = (layout.extent.to_array(), layout.channels, layout.frames);
    if shape != (facts.dims, facts.channels, facts.frames) {
        found.push(format!("shape {shape:?}"));
    }
    if !near(layout.spacing, facts.spacing) {
        found.push(format!("spacing {:?}", layout.spacing));
    }
    let mut hash = Sha256::new();
    let (mut min, mut max, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for frame in (0..layout.frames).map(FrameIndex) {
        for value in input.volume.frame_values(frame) {
            hash.update(value.to_le_bytes());
            let value = f64::from(value);
            (min, max, sum) = (value.min(min), value.max(max), sum + value);
        }
    }
    let hex = hash.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    });
    if hex != facts.sha256 {
        found.push(format!("samples hash to {hex}"));
    }
    // NumPy adds in another order.
    if (min, max) != (facts.min, facts.max) || (sum - facts.sum).abs() > 1e-6 * facts.sum.abs() + 1e-9 {
        found.push(format!("range {min} to {max}, sum {sum}"));
    }
    found
}

#[test]
fn every_sample_is_what_other_software_reads() {
    let Some(folder) = folder() else { return };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/independent_reader.py");
    let output = match Command::new("python3").arg(script).arg(&folder).output() {
        Ok(output) if output.status.success() => output,
        Ok(output) if output.status.code() != Some(3) => {
            panic!("the independent reader failed: {}", String::from_utf8_lossy(&output.stderr))
        }
        Ok(output) => {
            let missing = String::from_utf8_lossy(&output.stderr);
            return println!("skipped: no volume is read by other software: {}", missing.trim());
        }
        Err(error) => return println!("skipped: no volume is read by other software: python3: {error}"),
    };
    let text = String::from_utf8(output.stdout).unwrap();
    let mut facts: Vec<Facts> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let entries = entries(&folder);
    assert_eq!(facts.len(), entries.len());
    for (entry, facts) in entries.iter().zip(&mut facts) {
        assert_eq!(entry.name, facts.name);
        let input = entry.open(&folder);
        assert_eq!(differences(&input, facts), Vec::<String>::new(), "{}", entry.name);
        // The comparison notices one bit.
        let digit = if facts.sha256.starts_with('0') { "1" } else { "0" };
        facts.sha256.replace_range(..1, digit);
        facts.frames += 1;
        assert_eq!(differences(&input, facts).len(), 2, "{}", entry.name);
    }
}
