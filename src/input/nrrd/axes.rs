//! Which axis of an NRRD file is which: three in space, and besides at most one of values and one of time steps.

use super::super::axes::Axis;
use super::super::header::{Field, Fields, shown};
use super::super::layout::Shape;
use super::super::{InputError, Place};

const KINDS: &str = "three axes of kind domain or space, besides at most one of 1 or 3 values (RGB-color, 3-color, \
                     3-vector, vector, …) and at most one of frames (list, time)";

/// What runs along one axis.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Kind {
    Space,
    Values,
    Frames,
    Unknown,
}

/// The axes of a file, fastest first.
pub(super) struct Axes {
    pub axes: Vec<Axis>,
    pub shape: Shape,
    pub spacing: [f64; 3],
}

/// From `sizes`, `kinds`, `spacings` and `space directions` of a header of that many axes.
pub(super) fn read(fields: &Fields, dimension: usize) -> Result<Axes, InputError> {
    let sizes_field = fields.require("sizes", "sizes: 256 256 128")?;
    let sizes = sizes_field.sizes(dimension)?;
    let directions = match (fields.get("spacings"), fields.get("spacedirections")) {
        (Some(spacings), Some(directions)) => {
            let (first, second) =
                if spacings.line < directions.line { (spacings, directions) } else { (directions, spacings) };
            return Err(second.conflicts(first));
        }
        (None, Some(field)) => Some(direction_lengths(field, dimension)?),
        _ => None,
    };
    let kinds = kinds(fields, &sizes, directions.as_deref(), sizes_field)?;
    let mut next = [Axis::X, Axis::Y, Axis::Z].into_iter();
    let mut axes = Vec::new();
    let mut shape = Shape::scalar([1; 3]);
    let mut spatial = Vec::new();
    for (i, (kind, size)) in kinds.iter().zip(&sizes).enumerate() {
        match kind {
            Kind::Values => {
                axes.push(Axis::Channel);
                shape.channels = *size;
            }
            Kind::Frames => {
                axes.push(Axis::Frame);
                shape.frames = *size;
            }
            Kind::Space | Kind::Unknown => {
                if let Some(axis) = next.next() {
                    shape.dims[spatial.len()] = *size;
                    axes.push(axis);
                    spatial.push(i);
                }
            }
        }
    }
    let spacing = spacing(fields, directions.as_deref(), dimension, &spatial)?;
    Ok(Axes { axes, shape, spacing })
}

/// A kind for every axis: exactly three in space, and each other at most once.
fn kinds(
    fields: &Fields,
    sizes: &[u32],
    directions: Option<&[Option<f64>]>,
    sizes_field: &Field,
) -> Result<Vec<Kind>, InputError> {
    let mut kinds = vec![Kind::Unknown; sizes.len()];
    let mut named = None;
    if let Some(field) = fields.get("kinds") {
        let words: Vec<_> = field.value.split_whitespace().map(str::to_ascii_lowercase).collect();
        if words.len() != sizes.len() {
            return Err(field.malformed(&format!("{} kinds, one for each axis", sizes.len())));
        }
        for ((kind, word), size) in kinds.iter_mut().zip(&words).zip(sizes) {
            *kind = named_kind(word, *size).ok_or_else(|| field.unsupported(KINDS))?;
        }
        named = Some(field);
    }
    for (i, direction) in directions.into_iter().flatten().enumerate() {
        match (direction, kinds[i]) {
            (Some(_), Kind::Unknown) => kinds[i] = Kind::Space,
            (None, Kind::Unknown) if i == 0 && matches!(sizes[0], 1 | 3) => kinds[i] = Kind::Values,
            (None, Kind::Unknown) => kinds[i] = Kind::Frames,
            _ => {}
        }
    }
    let count = |kinds: &[Kind], kind| kinds.iter().filter(|k| **k == kind).count();
    if count(&kinds, Kind::Unknown) > 0 {
        by_position(&mut kinds, sizes, sizes_field)?;
    }
    let possible = count(&kinds, Kind::Space) == 3
        && count(&kinds, Kind::Values) <= 1
        && count(&kinds, Kind::Frames) <= 1;
    match (possible, named.or(fields.get("spacedirections"))) {
        (true, _) => Ok(kinds),
        (false, Some(field)) => Err(field.unsupported(KINDS)),
        (false, None) => Err(sizes_field.unsupported(KINDS)),
    }
}

/// Without a word on them, the axes are x, y, z; a fourth is that of frames; of five the first has the values.
fn by_position(kinds: &mut [Kind], sizes: &[u32], sizes_field: &Field) -> Result<(), InputError> {
    let all_unknown = kinds.iter().all(|k| *k == Kind::Unknown);
    if all_unknown && kinds.len() == 4 && sizes[0] == 3 {
        return Err(InputError::Header {
            place: sizes_field.place.clone(),
            problem: format!("`sizes` {} may be colours or frames", shown(&sizes_field.value)),
            remedy: "add `kinds: RGB-color domain domain domain` or `kinds: domain domain domain list`"
                .to_owned(),
        });
    }
    if all_unknown && kinds.len() == 5 && matches!(sizes[0], 1 | 3) {
        kinds[0] = Kind::Values;
    }
    for i in 0..kinds.len() {
        if kinds[i] == Kind::Unknown {
            let spatial = kinds.iter().filter(|k| **k == Kind::Space).count();
            kinds[i] = match spatial {
                0..3 => Kind::Space,
                _ if i == 0 && sizes[0] == 3 => Kind::Values,
                _ => Kind::Frames,
            };
        }
    }
    Ok(())
}

/// `None` for kinds that have no place here, and for values that are neither 1 nor 3.
fn named_kind(word: &str, size: u32) -> Option<Kind> {
    match word {
        "domain" | "space" => Some(Kind::Space),
        "list" | "time" => Some(Kind::Frames),
        "none" | "???" => Some(Kind::Unknown),
        "rgb-color" | "xyz-color" | "hsv-color" | "3-color" | "3-vector" | "3-gradient" | "3-normal" => {
            (size == 3).then_some(Kind::Values)
        }
        "vector" | "covariant-vector" | "scalar" | "stub" => matches!(size, 1 | 3).then_some(Kind::Values),
        _ => None,
    }
}

/// The spacing from `spacings`, or the lengths of the `space directions`, or 1.
fn spacing(
    fields: &Fields,
    directions: Option<&[Option<f64>]>,
    dimension: usize,
    spatial: &[usize],
) -> Result<[f64; 3], InputError> {
    let all: Vec<Option<f64>> = match (fields.get("spacings"), directions) {
        (Some(field), _) if dimension == 3 => return field.spacing(),
        (Some(field), _) => {
            let numbers: Vec<f64> =
                field.numbers_of(dimension, "a length for each axis, `nan` where it has none")?;
            let usable = |i: &usize| numbers[*i].is_finite() && numbers[*i] > 0.0;
            if !spatial.iter().all(usable) {
                return Err(field.malformed("a positive, finite length for each axis in space"));
            }
            numbers.into_iter().map(Some).collect()
        }
        (None, Some(directions)) => directions.to_vec(),
        (None, None) => return Ok([1.0; 3]),
    };
    let mut spacing = [1.0; 3];
    for (to, i) in spacing.iter_mut().zip(spatial) {
        *to = all[*i].ok_or_else(|| InputError::Header {
            place: fields.get("spacedirections").map_or_else(|| fields.file(), |f: &Field| f.place.clone()),
            problem: "an axis in space has the direction `none`".to_owned(),
            remedy: "give it a vector".to_owned(),
        })?;
    }
    Ok(spacing)
}

/// Lengths of the vectors `(a,b,c)`, each of three components, separated by white space; `None` for `none`.
fn direction_lengths(field: &Field, dimension: usize) -> Result<Vec<Option<f64>>, InputError> {
    let malformed = || match dimension {
        3 => field.malformed("three vectors of positive, finite length like `(0.5,0,0)`"),
        n => field.malformed(&format!(
            "{n} vectors of positive, finite length like `(0.5,0,0)`, `none` for axes that are not in space"
        )),
    };
    let mut lengths = Vec::new();
    let mut rest = field.value.as_str();
    for _ in 0..dimension {
        if let Some((word, after)) = rest.split_at_checked(4)
            && word.eq_ignore_ascii_case("none")
        {
            if dimension == 3 {
                return Err(field.unsupported("three spatial axes, each with a vector"));
            }
            lengths.push(None);
            rest = after.trim_start();
            continue;
        }
        let (vector, after) = rest.strip_prefix('(').and_then(|r| r.split_once(')')).ok_or_else(malformed)?;
        let components: Result<Vec<f64>, _> = vector.split(',').map(|c| c.trim().parse()).collect();
        let components: [f64; 3] = components.ok().and_then(|c| c.try_into().ok()).ok_or_else(malformed)?;
        let length = components.iter().map(|c| c * c).sum::<f64>().sqrt();
        if !length.is_finite() || length <= 0.0 {
            return Err(malformed());
        }
        lengths.push(Some(length));
        rest = after.trim_start();
    }
    if rest.is_empty() { Ok(lengths) } else { Err(malformed()) }
}

/// The dimension, 3 to 5.
pub(super) fn dimension(fields: &Fields) -> Result<usize, InputError> {
    let field = fields.require("dimension", "dimension: 3")?;
    match field.number::<u32>("a whole number")? {
        n @ 3..=5 => Ok(n as usize),
        _ => Err(field.unsupported("3 axes in space, besides at most one of 3 values and one of frames")),
    }
}

/// Where the sizes are claimed.
pub(super) fn place(fields: &Fields) -> Place {
    fields.get("sizes").map_or_else(|| fields.file(), |f| f.place.clone())
}
