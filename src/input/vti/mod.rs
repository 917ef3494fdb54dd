//! VTI, the XML format of VTK for `vtkImageData`: the VTK User's Guide, chapter "VTK XML File Formats", and
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.
//!
//! Read is one piece with its points' (else its cells') active scalars: text, base64 or raw, in place or appended,
//! as they are or in zlib blocks.

mod appended;
mod base64;
mod blocks;
mod data;
mod header;
mod xml;

use std::path::Path;

use super::header::{HeaderText, shown};
use super::layout::{Shape, StoredLayout};
use super::{InputError, InputVolume, Place};
use header::{Array, Association, Header};

/// Whether an XML file of VTK begins here: the root element stands in the first lines.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(4096)];
    let first = start.iter().find(|b| !b.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(b));
    first == Some(&b'<') && start.windows(8).any(|w| w == b"<VTKFile")
}

/// Reads the volume of this file.
pub(super) fn read(text: &HeaderText) -> Result<InputVolume, InputError> {
    let path = text.path();
    let header = xml::parse(path)?;
    let array = chosen(&header, path)?;
    data::read(path, &header, array, &layout_of(&header, array)?)
}

/// Its layout alone.
pub(super) fn layout(text: &HeaderText) -> Result<StoredLayout, InputError> {
    let header = xml::parse(text.path())?;
    layout_of(&header, chosen(&header, text.path())?)
}

fn layout_of(header: &Header, array: &Array) -> Result<StoredLayout, InputError> {
    let dims = match array.association {
        Association::Points => header.points,
        // An axis of one point has no cells along it, and is one cell thick.
        Association::Cells => header.points.map(|n| (n - 1).max(1)),
    };
    let channels = match array.components {
        n @ (1 | 3) => n,
        n => {
            return Err(InputError::Unsupported {
                place: array.place.clone(),
                found: format!("`NumberOfComponents` {n}"),
                supported: "1 (scalar) or 3 (RGB, vectors)".to_owned(),
            });
        }
    };
    let shape = Shape { dims, channels, frames: 1 };
    StoredLayout::new(&array.place, shape, header.spacing, array.stored)
}

/// Arrays with which VTK marks hidden points and cells; they are never the volume.
const GHOSTS: [&str; 2] = ["vtkGhostType", "vtkGhostLevels"];

/// The active scalars of the points, or their only array; without any, those of the cells.
fn chosen<'a>(header: &'a Header, path: &Path) -> Result<&'a Array, InputError> {
    for association in [Association::Points, Association::Cells] {
        let is_candidate = |a: &&Array| a.association == association && !GHOSTS.contains(&a.name.as_str());
        let arrays: Vec<&Array> = header.arrays.iter().filter(is_candidate).collect();
        let active = match association {
            Association::Points => &header.active_of_points,
            Association::Cells => &header.active_of_cells,
        };
        if let Some(name) = active {
            let named: Vec<&&Array> = arrays.iter().filter(|a| a.name == *name).collect();
            match named[..] {
                [] => {}
                [one] => return Ok(one),
                _ => {
                    return Err(InputError::Unsupported {
                        place: Place::part(path, format!("<{}>", association.element())),
                        found: format!("{} arrays called {}", named.len(), shown(name)),
                        supported: "one; write each to a file of its own".to_owned(),
                    });
                }
            }
        }
        match arrays[..] {
            [] => {}
            [one] => return Ok(one),
            _ => {
                let names: Vec<String> = arrays.iter().map(|a| shown(&a.name)).collect();
                return Err(InputError::Header {
                    place: Place::part(path, format!("<{}>", association.element())),
                    problem: format!("which array is the volume is not said: there are {}", names.join(", ")),
                    remedy: format!("add `Scalars=\"NAME\"` to <{}>", association.element()),
                });
            }
        }
    }
    Err(InputError::Header {
        place: Place::file(path),
        problem: "there is no <DataArray> in <PointData> or <CellData>".to_owned(),
        remedy: "save the volume with its values".to_owned(),
    })
}
