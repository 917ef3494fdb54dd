//! The columns of records that came with this list, in their order.

/// Calls a macro with the names of the figures that records hold behind their first columns, in the order of these
/// columns. A new one is added at the end. A metric's file documents it ([`crate::metrics::figures`]).
#[macro_export]
macro_rules! for_each_figure {
    ($consume:ident) => {
        $consume! {
            mean_abs_error
            rmse
            p999_abs_error
            error_autocorrelation
            gradient_error
            block_discontinuity
            isosurface_distance_voxels
            isosurface_max_distance_voxels
            image_ms_ssim
            image_ms_ssim_whole
            image_flip
            image_flip_whole
            codec_image_ms_ssim
            codec_image_flip
        }
    };
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crate::metrics::{Figure, figures};

    macro_rules! names {
        ($($name:ident)*) => { [$(stringify!($name)),*] };
    }

    /// Columns that records had before the list.
    const FIRST: [&str; 12] = [
        "psnr_db",
        "foreground_psnr_db",
        "max_abs_error",
        "psnr_red_db",
        "psnr_green_db",
        "psnr_blue_db",
        "image_psnr_db",
        "image_ssim",
        "image_psnr_whole_db",
        "image_ssim_whole",
        "codec_image_psnr_db",
        "codec_image_ssim",
    ];

    #[test]
    fn every_figure_has_a_column_and_every_column_a_figure() {
        let columns: BTreeSet<&str> = for_each_figure!(names).into_iter().chain(FIRST).collect();
        let named: BTreeSet<&str> = figures().map(|figure| figure.name).collect();
        assert_eq!(columns, named);
        assert_eq!(figures().count(), named.len(), "each stands once");
        assert_eq!(for_each_figure!(names).len() + FIRST.len(), columns.len());
    }

    /// The table of `docs/user/evaluation.md` is that of the list, row by row.
    #[test]
    fn the_documentation_has_every_definition() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/user/evaluation.md");
        let text = std::fs::read_to_string(path).unwrap();
        let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| `")).collect();
        let expected: Vec<String> = figures().map(Figure::row).collect();
        for row in &expected {
            assert!(
                rows.contains(&row.as_str()),
                "docs/user/evaluation.md lacks this row, letter by letter:\n{row}"
            );
        }
        let of_figures = |row: &&&str| {
            let name = row.trim_start_matches("| `").split('`').next().unwrap_or_default();
            figures().any(|figure| figure.name == name)
        };
        assert_eq!(rows.iter().filter(of_figures).count(), expected.len(), "a figure has two rows");
        let other = Figure { unit: "parsec", ..*figures().next().unwrap() };
        assert!(!rows.contains(&other.row().as_str()));
    }
}
