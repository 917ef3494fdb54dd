//! Texts of records about comparing sites with the CPU decoder, for runs and `cvr render`.

use cvr_core::codec::Site;

use super::record::{Record, Status};
use crate::site::coded::CodedFrame;
use crate::site::expected::Checked;
use crate::site::holding::{Holding, Preparation};
use crate::site::target::Target;

/// Beginning of the remark if a device would have decoded, but none did.
pub const SHADER_NOT_RUN: &str = "shader not run";

/// The number of cells without a compared shader, as a sentence. `None` if there are none.
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

/// Adds the remark to a record of an older version: a cell without a comparison, although a device makes one.
pub fn restore(record: &mut Record) {
    let compares = record.site.parse().is_ok_and(|site: Site| site.decoded_by().on_device());
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
    /// Whether a device would have decoded the cell's voxels, but none did. Such a cell does not test the shader.
    #[must_use]
    pub fn shader_not_run(&self) -> bool {
        self.notes.iter().flat_map(|notes| notes.split("; ")).any(|note| note.starts_with(SHADER_NOT_RUN))
    }

    /// Remarks that the CPU mirror draws a frame of a site: the device's decoding is not compared, and the mirror may
    /// draw from another source.
    pub fn flag_mirror(&mut self, target: &Target, holding: &dyn Holding, coded: CodedFrame<'_>) {
        let Target::Cpu { .. } = target else { return };
        if holding.device_decodes(coded) {
            flag(self);
        }
        if let Some(remark) = holding.mirror_remark() {
            self.remark(remark);
        }
    }

    /// Enters time and fallbacks of preparing a frame.
    pub fn enter_preparation(&mut self, preparation: &Preparation) {
        let Preparation { device_decode_ms, device_decode_bytes, remarks } = preparation;
        self.device_decode_ms = *device_decode_ms;
        self.device_decode_bytes = *device_decode_bytes;
        remarks.iter().for_each(|remark| self.remark(remark));
    }

    /// Enters the result of a comparison.
    ///
    /// # Errors
    /// What is wrong.
    pub fn enter_checked(&mut self, checked: &Checked) -> Result<(), String> {
        self.parity_mismatches = Some(checked.mismatches);
        if let Some(problem) = &checked.problem {
            return Err(problem.clone());
        }
        if let Some(remark) = &checked.remark {
            self.remark(remark);
        }
        Ok(())
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
            remark: None,
        };
        let both = found(0, 0.25, None).and(found(3, 0.5, Some("b")));
        assert_eq!(both, found(3, 0.5, Some("b")));
        let mut record = Record::default();
        assert_eq!(record.enter_checked(&found(1, 0.0, Some("a")).and(both)), Err("a".to_owned()));
        assert_eq!(record.parity_mismatches, Some(4));
        assert!(found(0, f64::NAN, None).and(found(0, 1.0, None)).largest.is_nan());
        assert_eq!(record.enter_checked(&found(0, 1.0, None)), Ok(()));
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
