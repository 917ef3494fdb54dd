//! The finished cells of a run, in order, in memory and on disk.

use cvr_core::codec::Settings;
use cvr_core::pipeline::{Cell, FrameRange};

use super::outcome::{Outcome, RunError};
use crate::experiment::files::cell_file::CellFile;
use crate::experiment::files::flaws::Flawed;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::{IMAGES, of_frame};
use crate::experiment::files::whole_file::ResultsError;
use crate::experiment::files::write_results::{write_csv, write_json};
use crate::experiment::measured::reference::REFERENCE;
use crate::experiment::records::provenance::{Provenance, ReferencePicture, RefusedCell};
use crate::experiment::records::record::{Record, Status};

/// Records and reference pictures of a run.
pub(super) struct Ledger<'a> {
    out: &'a OutFolder,
    records: Vec<Option<Record>>,
    references: Vec<Reference>,
    refused: Vec<RefusedCell>,
    provenance: Provenance,
    taken_over: usize,
    flawed: Flawed,
    /// Volumes that were encoded, the baseline among them.
    pub(super) encodings: usize,
}

struct Reference {
    picture: ReferencePicture,
    ready: bool,
}

impl<'a> Ledger<'a> {
    /// `frames_of` gives the frames that a cell's scene draws.
    pub(super) fn new(
        out: &'a OutFolder,
        cells: &[Cell],
        frames_of: impl Fn(&Cell) -> FrameRange,
        refused: Vec<RefusedCell>,
        provenance: Provenance,
    ) -> Self {
        let mut references: Vec<Reference> = Vec::new();
        for cell in cells {
            if !references.iter().any(|r| is_of(&r.picture, cell)) {
                let image = format!("{IMAGES}/{}.png", reference_id(cell));
                let picture = ReferencePicture {
                    volume: cell.volume.clone(),
                    scene: cell.scene.clone(),
                    renderer: cell.renderer.clone(),
                    later_frames: frames_of(cell).iter().skip(1).map(|f| of_frame(&image, f)).collect(),
                    image,
                };
                references.push(Reference { picture, ready: false });
            }
        }
        let records = vec![None; cells.len()];
        let (taken_over, flawed, encodings) = (0, Flawed::default(), 0);
        Self { out, records, references, refused, provenance, taken_over, flawed, encodings }
    }

    /// Takes over this cell from an earlier run, if it is in the folder with the same key. `expected` is its record
    /// before it runs.
    pub(super) fn take_over(&mut self, index: usize, cell: &Cell, key: &str, expected: &Record) {
        let file = match CellFile::taken_over(self.out.path(), cell, key, expected) {
            Ok(file) => file,
            Err(flaw) => return self.flawed.add(flaw, &cell.id()),
        };
        if let Some(reference) = self.references.iter_mut().find(|r| is_of(&r.picture, cell)) {
            let intact = reference.picture.files().all(|path| file.is_intact(self.out.path(), path));
            reference.ready = reference.ready || intact;
        }
        self.records[index] = Some(file.record);
        self.taken_over += 1;
    }

    /// Lists the cells that are run again although they have a record.
    pub(super) fn tell_flawed(&self) {
        self.flawed.lines().for_each(|line| eprintln!("{line}"));
    }

    /// Whether the cell of this number is finished.
    pub(super) fn has(&self, index: usize) -> bool {
        self.records[index].is_some()
    }

    /// Cells that are finished.
    pub(super) fn done(&self) -> usize {
        self.records.iter().flatten().count()
    }

    /// Whether the reference picture of a cell is in the folder.
    pub(super) fn has_reference(&self, cell: &Cell) -> bool {
        self.references.iter().any(|r| r.ready && is_of(&r.picture, cell))
    }

    /// Paths of the reference pictures of a cell, one per frame.
    pub(super) fn reference_files(&self, cell: &Cell) -> Vec<String> {
        let reference = self.references.iter().find(|r| is_of(&r.picture, cell));
        reference.into_iter().flat_map(|r| r.picture.files()).map(str::to_owned).collect()
    }

    /// Records that the reference pictures of a cell were written.
    pub(super) fn add_reference(&mut self, cell: &Cell) {
        self.references.iter_mut().filter(|r| is_of(&r.picture, cell)).for_each(|r| r.ready = true);
    }

    /// Puts a record on disk, alone and among the others.
    pub(super) fn finish(
        &mut self,
        index: usize,
        cell: &Cell,
        mut record: Record,
        key: String,
        result: Result<(), String>,
    ) -> Result<(), RunError> {
        match result {
            Ok(()) => record.status = Status::Ok,
            Err(problem) => record.error = Some(problem),
        }
        if record.status == Status::Ok {
            self.out.begin().map_err(fail)?;
        }
        let reference = self.references.iter().find(|r| r.ready && is_of(&r.picture, cell));
        let reference = reference.into_iter().flat_map(|r| r.picture.files());
        let file = CellFile::new(record, Some(key), &self.out.current(), reference);
        file.write(self.out, &cell.id()).map_err(fail)?;
        self.records[index] = Some(file.record);
        self.write()
    }

    /// Writes `results.csv` and `results.json` with the finished cells.
    pub(super) fn write(&mut self) -> Result<(), RunError> {
        let ready = self.references.iter().filter(|r| r.ready);
        self.provenance.references = ready.map(|r| r.picture.clone()).collect();
        let records: Vec<Record> = self.records.iter().flatten().cloned().collect();
        write_csv(self.out, &records).map_err(fail)?;
        write_json(self.out, &self.provenance, &records, &self.refused).map_err(fail)
    }

    pub(super) fn into_outcome(self) -> Outcome {
        Outcome {
            missing: self.records.iter().filter(|r| r.is_none()).count(),
            records: self.records.into_iter().flatten().collect(),
            refused: self.refused,
            provenance: self.provenance,
            taken_over: self.taken_over,
            encodings: self.encodings,
        }
    }
}

fn fail(error: ResultsError) -> RunError {
    RunError(error.to_string())
}

/// Whether a picture is the reference of a cell.
fn is_of(picture: &ReferencePicture, cell: &Cell) -> bool {
    picture.volume == cell.volume && picture.scene == cell.scene && picture.renderer == cell.renderer
}

/// Name of a cell's reference picture. It does not depend on the cell that asks first, so shards agree.
fn reference_id(cell: &Cell) -> String {
    let (codec, settings) = (String::new(), Settings::default());
    let (site, filter) = REFERENCE;
    let (stages, resolution) = (None, 0);
    let reference =
        Cell { codec, settings, site, filter, skipping: false, stages, resolution, ..cell.clone() };
    format!("reference-{}", reference.id())
}
