//! The identity of an experiment: its parsed configuration (comments and the order of keys do not count), the overrides
//! of `--set` (paths of files do not count), the seed, and the content of the volumes. The device is not part of it.

use serde::Serialize;

use super::key::hash_of;
use super::owner::{Kind, Owner};
use crate::experiment::records::provenance::{Provenance, VolumeProvenance};

/// The owner of a run's results.
#[must_use]
pub fn owner(provenance: &Provenance) -> Owner {
    #[derive(Serialize)]
    struct Inputs<'a> {
        config: String,
        overrides: Vec<&'a String>,
        seed: u64,
        volumes: Vec<OfVolume<'a>>,
    }
    let inputs = Inputs {
        config: config(provenance),
        overrides: overrides(provenance),
        seed: provenance.seed,
        volumes: provenance.volumes.iter().map(of_volume).collect(),
    };
    Owner { kind: Kind::Run, experiment: provenance.experiment.clone(), identity: hash_of(&inputs) }
}

/// Name, hash of the samples, voxels along each axis, number type, and spacing.
type OfVolume<'a> = (&'a str, &'a str, [u32; 3], &'a str, String);

fn of_volume(v: &VolumeProvenance) -> OfVolume<'_> {
    (&v.name, &v.blake3, v.dims, &v.dtype, format!("{:?}", v.spacing))
}

/// The first difference between two experiments, as text that follows the name of the first.
#[must_use]
pub fn difference(a: &Provenance, b: &Provenance, other: &str) -> Option<String> {
    if config(a) != config(b) {
        return Some(format!("its configuration is not that of {other}"));
    }
    let [ours, theirs] = [a, b].map(|p| overrides(p).into_iter().cloned().collect::<Vec<_>>().join(" "));
    if ours != theirs {
        return Some(format!("it ran with --set {ours:?}, {other} with {theirs:?}"));
    }
    if a.seed != b.seed {
        return Some(format!("its seed is {}, that of {other} {}", a.seed, b.seed));
    }
    let names = |p: &Provenance| p.volumes.iter().map(|v| v.name.clone()).collect::<Vec<_>>();
    if names(a) != names(b) {
        let (a, b) = (names(a).join(", "), names(b).join(", "));
        return Some(format!("its volumes are {a}, those of {other} {b}"));
    }
    let pairs = a.volumes.iter().zip(&b.volumes);
    pairs
        .filter(|(a, b)| (&a.blake3, a.dims, &a.dtype, a.spacing) != (&b.blake3, b.dims, &b.dtype, b.spacing))
        .map(|(a, b)| {
            format!(
                "volume `{}` is not that of {other}: blake3 {} and {}, {} {:?} and {} {:?}, spacing {:?} and {:?}",
                a.name, a.blake3, b.blake3, a.dtype, a.dims, b.dtype, b.dims, a.spacing, b.spacing
            )
        })
        .next()
}

/// The configuration without comments, its keys in a fixed order. Unchanged if it is not TOML.
fn config(provenance: &Provenance) -> String {
    let parsed = provenance.config.parse::<toml::Table>();
    parsed.map_or_else(|_| provenance.config.clone(), |table| format!("{table:?}"))
}

/// Paths of files differ between machines. The volumes are compared by content.
fn overrides(provenance: &Provenance) -> Vec<&String> {
    let is_path = |o: &str| o.split('=').next().is_some_and(|key| key.trim().ends_with(".file"));
    provenance.overrides.iter().filter(|o| !is_path(o)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn provenance() -> Provenance {
        let volume =
            VolumeProvenance { name: "v".to_owned(), blake3: "0".to_owned(), ..VolumeProvenance::default() };
        Provenance {
            config: "[a]\nx = 1 # one\ny = [1.0, 2.0]\n[b]\nz = 'q'\n".to_owned(),
            overrides: vec!["a.x=2".to_owned()],
            seed: 3,
            volumes: vec![volume],
            ..Provenance::default()
        }
    }

    #[test]
    fn what_is_no_part_of_an_experiment_makes_no_other() {
        let first = provenance();
        let mut same = provenance();
        same.config = "[b]\nz = \"q\"\n\n[a]\ny = [1.0,\n 2.0]\nx = 1\n".to_owned();
        same.overrides.push("volume.v.file=/elsewhere/v.nrrd".to_owned());
        (same.adapter, same.date, same.cores) = ("other".to_owned(), "later".to_owned(), 7);
        assert_eq!((owner(&same), difference(&same, &first, "b")), (owner(&first), None));
        type Change = fn(&mut Provenance);
        let changes: [(&str, Change); 7] = [
            ("configuration", |p| p.config = p.config.replace("x = 1", "x = 2")),
            ("--set", |p| p.overrides.push("a.x=3".to_owned())),
            ("seed", |p| p.seed = 4),
            ("volumes", |p| p.volumes[0].name.push('2')),
            ("blake3", |p| p.volumes[0].blake3.push('2')),
            ("spacing", |p| p.volumes[0].spacing[1] = 2.0),
            ("configuration", |p| p.config = "no TOML".to_owned()),
        ];
        for (what, change) in changes {
            let mut other = provenance();
            change(&mut other);
            assert_ne!(owner(&other).identity, owner(&first).identity, "{what}");
            let said = difference(&other, &first, "b").unwrap();
            assert!(said.contains(what), "{said}");
        }
    }
}
