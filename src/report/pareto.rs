//! Which cells no other cell beats.

use crate::experiment::records::record::Record;

use super::cells::{View, compressed, shown};

/// Indices of the points that no other point matches in both and beats in one, in rising order of the first
/// coordinate; both are costs. Of equal points the first counts. Points that are not numbers never count.
pub(super) fn front(costs: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..costs.len()).filter(|i| !costs[*i].0.is_nan() && !costs[*i].1.is_nan()).collect();
    order.sort_by(|a, b| {
        let (a, b) = (costs[*a], costs[*b]);
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut best: Option<f64> = None;
    order.retain(|i| {
        let better = best.is_none_or(|b| costs[*i].1 < b);
        if better {
            best = Some(costs[*i].1);
        }
        better
    });
    order
}

/// The compressed cells of a view on one device that none beats in both frame time and picture, fastest first.
/// Uncompressed cells are the yardstick; failed ones, and those of scenes that show nothing, do not compete.
pub(super) fn of_view<'a>(records: &'a [Record], view: &View, device: &str) -> Vec<&'a Record> {
    let cells: Vec<(&Record, (f64, f64))> = records
        .iter()
        .filter(|r| shown(r) && compressed(r) && View::of(r) == *view && r.device == device)
        .filter_map(|r| Some((r, (r.relative_frame_time?, -r.image_psnr_db?))))
        .collect();
    let costs: Vec<_> = cells.iter().map(|c| c.1).collect();
    front(&costs).into_iter().map(|i| cells[i].0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::Status;
    use crate::experiment::records::record::tests::record;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points =
            [(2.0, 5.0), (1.0, 9.0), (3.0, 5.0), (2.0, 4.0), (4.0, 1.0), (f64::NAN, 0.0), (4.0, 1.0)];
        assert_eq!(front(&points), [1, 3, 4]);
        assert_eq!(front(&[]), [0usize; 0]);
        assert_eq!(front(&[(1.0, f64::NEG_INFINITY), (0.5, 0.0)]), [1, 0]);
        assert_eq!(front(&[(1.0, f64::INFINITY)]), [0]);
    }

    #[test]
    fn failures_and_the_uncompressed_do_not_compete() {
        let cell = |codec: &str, time: f64, psnr: f64| Record {
            relative_frame_time: Some(time),
            image_psnr_db: Some(psnr),
            ..record("v", codec)
        };
        let mut broken = cell("s3dc", 0.1, 99.0);
        broken.status = Status::Failed;
        let blank = Record { visible_pixels: Some(0), ..cell("s3dc", 0.1, f64::INFINITY) };
        let records = [
            cell("raw", 0.5, f64::INFINITY),
            broken,
            cell("s3dc", 2.0, 40.0),
            cell("s3dc", 3.0, 39.0),
            blank,
        ];
        let front = of_view(&records, &View::of(&records[0]), "");
        assert_eq!(front, [&records[2]]);
        assert!(of_view(&records, &View::of(&records[0]), "another").is_empty());
    }
}
