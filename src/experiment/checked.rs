//! What a site draws from, held to what the CPU decodes. Runs and `cvr render` compare by this, and tell of it in these
//! words.

use std::sync::Arc;

use cvr_core::codec::{Block, Decoder, Parity, Site, VoxelDump as _};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FrameIndex, Level};

use super::deferred::DeferredVolume;
use super::record::{Record, Status};
use super::target::{HostVolume, Picture, Target};

/// How the remark begins that a record has where a device would have decoded, and none did.
pub const SHADER_NOT_RUN: &str = "shader not run";

/// A frame of a stream at a level as the CPU decodes it: what sites are held to.
#[derive(Clone, Debug)]
pub struct Expected<'a> {
    /// Codec id.
    pub codec: &'a str,
    /// The opened stream.
    pub decoder: &'a dyn Decoder,
    /// The frame's place in it.
    pub key: (FrameIndex, Level),
    /// What the CPU decodes.
    pub frame: Arc<DecodedFrame>,
    /// The codec's block, if it has one: a mismatch is told with it.
    pub block: Option<Block>,
}

/// What comparing has found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checked {
    /// Samples beyond what is stated.
    pub mismatches: u64,
    /// The largest distance of any sample, in data units.
    pub largest: f64,
    /// What is wrong, with the first mismatch in words; `None` where all agree.
    pub problem: Option<String>,
}

impl Checked {
    /// `what` decodes on the device, with its verb.
    fn new(what: &str, parity: &Parity, block: Option<Block>) -> Self {
        let problem = || format!("{what} is not what the CPU decodes: {}", parity.with_block(block));
        let Parity { mismatches, largest, .. } = *parity;
        Self { mismatches, largest, problem: (!parity.holds()).then(problem) }
    }

    /// Both together; the first problem is told.
    fn and(self, other: Self) -> Self {
        Self {
            mismatches: self.mismatches + other.mismatches,
            largest: if self.largest > other.largest || self.largest.is_nan() {
                self.largest
            } else {
                other.largest
            },
            problem: self.problem.or(other.problem),
        }
    }

    /// Enters the count into a record.
    ///
    /// # Errors
    /// What is wrong.
    pub fn enter(&self, record: &mut Record) -> Result<(), String> {
        record.parity_mismatches = Some(self.mismatches);
        self.problem.clone().map_or(Ok(()), Err)
    }
}

impl Expected<'_> {
    /// Every voxel as the generated shader fetches it, and through `fetch_cell` too where `use_cell` says so; `None` where
    /// no device draws, or the codec has no shader.
    ///
    /// # Errors
    /// A sentence, when the device cannot run the shader.
    pub fn inline(&self, target: &Target, use_cell: bool) -> Result<Option<Checked>, String> {
        let (Target::Device(device), Some(shader)) = (target, self.decoder.shader()) else { return Ok(None) };
        let by = |what: &str, use_cell: bool| {
            let dump = device.dump_at(self.codec, self.decoder, self.key, use_cell)?;
            let cpu = self.frame.values();
            let parity = Parity::compare_at(self.decoder, shader.agreement(), self.key, cpu, &dump);
            Ok::<_, String>(Checked::new(what, &parity, self.block))
        };
        let fetched = by("what the shader fetches", false)?;
        if !use_cell {
            return Ok(Some(fetched));
        }
        Ok(Some(fetched.and(by("what the shader fetches as cells (fetch_cell)", true)?)))
    }

    /// The texels that the device decoded; `None` where none did.
    ///
    /// # Errors
    /// A sentence, when they cannot be read back.
    pub fn deferred(&self, target: &Target, volume: &DeferredVolume) -> Result<Option<Checked>, String> {
        let parity = volume.parity(target, self.decoder, self.key, &self.frame).map_err(|e| e.to_string())?;
        Ok(parity.map(|parity| Checked::new("what the device decoded", &parity, self.block)))
    }

    /// The blocks that the texture unit decodes; `None` where the texture holds what the CPU decoded.
    ///
    /// # Errors
    /// A sentence, when the texture cannot be read.
    pub fn host(&self, target: &Target, volume: &HostVolume) -> Result<Option<Checked>, String> {
        let parity = volume.parity(target, self.decoder, self.key).map_err(|e| e.to_string())?;
        Ok(parity.map(|parity| Checked::new("what the texture unit decodes", &parity, self.block)))
    }

    /// The voxels that come through the ring of a picture; `None` where the mirror draws, which has none.
    ///
    /// # Errors
    /// A sentence, when they cannot be read back.
    pub fn ring(&self, picture: &Picture<'_>) -> Result<Option<Checked>, String> {
        let Some(values) = picture.read_layers().map_err(|e| e.to_string())? else { return Ok(None) };
        let shader = self.decoder.shader().ok_or("a ring of layers without a shader that decodes them")?;
        let cpu = self.frame.values();
        let parity = Parity::compare_at(self.decoder, shader.agreement(), self.key, cpu, &values);
        Ok(Some(Checked::new("what came through the ring", &parity, self.block)))
    }

    /// Remarks that nothing is compared where the mirror draws, of sites at which a device would have decoded: by a shader,
    /// or by texture units out of the codec's blocks.
    pub fn flag_not_run(&self, target: &Target, site: Site, record: &mut Record) {
        let Target::Cpu { .. } = target else { return };
        let blocks = || self.decoder.layout().channels == 1;
        let blocks = || blocks() && self.decoder.block_texture(self.key.0, self.key.1).is_some();
        if site != Site::Host || blocks() {
            flag(record);
        }
    }
}

/// Of how many cells no shader was compared, in a sentence; `None` where there is no such cell.
#[must_use]
pub fn not_run(records: &[Record]) -> Option<String> {
    let n = records.iter().filter(|record| record.shader_not_run()).count();
    let all = records.len();
    (n > 0).then(|| {
        format!(
            "{SHADER_NOT_RUN}: {n} of {all} cells were drawn by the CPU mirror; what a device would decode was not compared, \
             and a wrong shader shows in none of them."
        )
    })
}

/// Remarks it in a record of versions that did not: a cell that ended well without a comparison where a device makes one.
pub fn restore(record: &mut Record) {
    let compares = [Site::Inline, Site::Deferred, Site::Ring].iter().any(|site| site.name() == record.site);
    if compares && record.status == Status::Ok && record.device == "cpu" && record.parity_mismatches.is_none()
    {
        flag(record);
    }
}

fn flag(record: &mut Record) {
    if !record.shader_not_run() {
        record.remark(&format!(
            "{SHADER_NOT_RUN}: the CPU mirror drew, and what a device would decode was not compared with the CPU decoder"
        ));
    }
}

impl Record {
    /// Whether a device would have decoded what the cell draws, and none did: the cell says nothing of the shader.
    #[must_use]
    pub fn shader_not_run(&self) -> bool {
        self.notes.iter().flat_map(|notes| notes.split("; ")).any(|note| note.starts_with(SHADER_NOT_RUN))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_to_fetch_count_and_the_first_that_fails_is_told() {
        let found = |mismatches, largest, problem: Option<&str>| Checked {
            mismatches,
            largest,
            problem: problem.map(str::to_owned),
        };
        let both = found(0, 0.25, None).and(found(3, 0.5, Some("b")));
        assert_eq!(both, found(3, 0.5, Some("b")));
        let mut record = Record::default();
        assert_eq!(found(1, 0.0, Some("a")).and(both).enter(&mut record), Err("a".to_owned()));
        assert_eq!(record.parity_mismatches, Some(4));
        assert!(found(0, f64::NAN, None).and(found(0, 1.0, None)).largest.is_nan());
        assert_eq!(found(0, 1.0, None).enter(&mut record), Ok(()));
        assert_eq!(record.parity_mismatches, Some(0));
    }

    #[test]
    fn older_records_of_the_mirror_learn_that_no_shader_ran() {
        let told = |site: &str, device: &str, mismatches| {
            let (site, device) = (site.to_owned(), device.to_owned());
            let mut r = Record {
                site,
                device,
                parity_mismatches: mismatches,
                status: Status::Ok,
                ..Record::default()
            };
            restore(&mut r);
            restore(&mut r);
            r.notes.map_or(0, |notes| notes.matches(SHADER_NOT_RUN).count())
        };
        assert_eq!(
            [told("inline", "cpu", None), told("ring", "cpu", None), told("host", "cpu", None)],
            [1, 1, 0]
        );
        assert_eq!([told("inline", "llvmpipe", Some(0)), told("inline", "cpu", Some(0))], [0, 0]);
    }

    #[test]
    fn a_run_tells_how_many_cells_no_shader_drew() {
        let noted = |notes: &str| Record { notes: Some(notes.to_owned()), ..Record::default() };
        assert_eq!(not_run(&[Record::default(), noted("a")]), None);
        let told = not_run(&[noted("shader not run: x"), Record::default()]).unwrap();
        assert!(told.starts_with("shader not run: 1 of 2 cells"), "{told}");
    }

    #[test]
    fn only_the_remark_itself_says_that_no_shader_ran() {
        let told =
            |notes: &str| Record { notes: Some(notes.to_owned()), ..Record::default() }.shader_not_run();
        assert!(told("shader not run: the CPU mirror drew") && told("a; shader not run: b; c"));
        assert!(!told("of a codec: shader not run") && !Record::default().shader_not_run());
    }
}
