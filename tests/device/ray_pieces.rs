//! Rays followed in pieces give the same picture as rays followed at once, in every bit.

use cvr_core::codec::Site;
use cvr_core::render::{Filter, Filter::*};
use cvr_core::render::{Image, Light, Plan, Projection, RayWalk, Renderer, Stage, Template, View};
use cvr_core::volume::{FiniteVolume, SampleType};
use cvr_engine::testing::test_device;
use cvr_engine::{Device, DrawSource, Drawing, EngineError, RayPieces};
use cvr_raycasting::Raycasting;

use super::colour::{self, coloured};
use super::scenes::{camera, clipped, lit, source, textured, view};
use super::skipping::{macrocells, mismatches, sparse, views, visible};
use super::subjects::{codec, encoded, settings};

const SIZE: [u32; 2] = [50, 41];

/// A picture in pieces of this many samples. It is drawn twice: the first drawing must not affect the second.
fn in_pieces(
    device: &Device,
    (plan, source, filter): (&Plan, &DrawSource<'_>, Filter),
    samples: u32,
) -> Result<(Image, RayPieces), EngineError> {
    let drawing = Drawing::new(device, plan, source, filter)?.with_rays_in_pieces(samples)?;
    drawing.draw_timed()?;
    Ok((drawing.read_image()?, drawing.ray_pieces().unwrap()))
}

fn at_once(device: &Device, plan: &Plan, source: &DrawSource<'_>, filter: Filter) -> Image {
    let drawing = Drawing::new(device, plan, source, filter).unwrap();
    drawing.draw_timed().unwrap();
    assert_eq!(drawing.ray_pieces(), None, "this picture needs no pieces");
    drawing.read_image().unwrap()
}

struct Subject {
    codec: &'static str,
    settings: &'static [(&'static str, &'static str)],
    site: Site,
    volume: FiniteVolume,
    view: View,
}

fn subjects() -> Vec<Subject> {
    let scalar = |codec, settings, site, sample, view| {
        let volume = textured([19, 23, 17], [1.0, 1.4, 0.8], sample);
        Subject { codec, settings, site, volume, view }
    };
    let of = |sample, filter| view(sample, SIZE, filter);
    let turned = |view, projection| View { camera: camera(-50.0, -20.0, projection), ..view };
    let (u8, i16, f32) = (SampleType::U8, SampleType::I16, SampleType::F32);
    let red = coloured(u8);
    let skips = |filter, i: usize| views(filter)[i].clone();
    vec![
        scalar("s3dc", &[("block", "4")], Site::Inline, f32, of(f32, Nearest)),
        scalar(
            "s3dc",
            &[("block", "4")],
            Site::Inline,
            u8,
            lit(turned(of(u8, OptimisedLinear), Projection::Orthographic), Light::Camera),
        ),
        scalar(
            "raw",
            &[],
            Site::Inline,
            i16,
            View { termination: 0.6, ..clipped(lit(of(i16, Linear), Light::Fixed)) },
        ),
        scalar("raw", &[], Site::Host, u8, clipped(of(u8, Linear))),
        scalar("zfp", &[("rate", "8")], Site::Inline, u8, turned(of(u8, Nearest), Projection::Orthographic)),
        Subject {
            codec: "raw",
            settings: &[],
            site: Site::Inline,
            view: View { size: SIZE, ..colour::views(u8, &red).pop().unwrap() },
            volume: red,
        },
        Subject {
            codec: "vq",
            settings: &[],
            site: Site::Inline,
            volume: sparse(SampleType::I8),
            view: skips(Linear, 0),
        },
        Subject {
            codec: "raw",
            settings: &[],
            site: Site::Host,
            volume: sparse(SampleType::I8),
            view: skips(Nearest, 1),
        },
    ]
}

#[test]
fn pieces_of_any_length_make_the_picture_of_rays_walked_at_once() {
    let Some(device) = test_device("ray_pieces::equal") else { return };
    for (number, subject) in subjects().into_iter().enumerate() {
        let Subject { codec: id, settings: pairs, site, volume, mut view } = subject;
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &volume);
        // The last two leap over macrocells.
        if number >= 6 {
            view.macrocells = Some(macrocells(decoder.as_ref(), &view));
        }
        let source = source(device, site, id, decoder.as_ref());
        let plan = Raycasting.plan(&view, decoder.layout()).unwrap();
        let whole = at_once(device, &plan, &source, view.filter);
        assert!(visible(&whole) > 100, "{number}, {id}: {}", visible(&whole));
        let mut longest = 0;
        for samples in [1, 4, 13, 1000] {
            let (picture, found) = in_pieces(device, (&plan, &source, view.filter), samples).unwrap();
            assert_eq!(mismatches(&whole, &picture), 0, "{number}, {id} at {site} in pieces of {samples}");
            longest = if samples == 1 { found.pieces } else { longest };
            assert!(longest > 8, "{number}: the longest ray has {longest} samples");
            assert_eq!(found, RayPieces { samples, pieces: longest.div_ceil(samples) }, "{number}, {id}");
        }
    }
}

/// The plan with another module for pieces, in which `from` is replaced by `to`.
fn mutated(plan: &Plan, from: &str, to: &str) -> Plan {
    let mut plan = plan.clone();
    let [pass] = &mut plan.passes[..] else { panic!("one pass") };
    let Stage::Rays(RayWalk { in_pieces, .. }) = &mut pass.pipeline.stage else { panic!("rays") };
    assert!(in_pieces.source.contains(from), "the module has changed: it holds no `{from}`");
    let source: &'static str = in_pieces.source.replace(from, to).leak();
    *in_pieces = Template { source, ..*in_pieces };
    plan
}

#[test]
fn a_wrong_continuation_is_noticed() {
    let Some(device) = test_device("ray_pieces::twins") else { return };
    let volume = textured([19, 23, 17], [1.0; 3], SampleType::U8);
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &volume);
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    let view = view(SampleType::U8, SIZE, Nearest);
    let plan = Raycasting.plan(&view, decoder.layout()).unwrap();
    let whole = at_once(device, &plan, &source, Nearest);
    let wrong = |from, to| {
        let plan = mutated(&plan, from, to);
        let (picture, _) = in_pieces(device, (&plan, &source, Nearest), 5)?;
        Ok::<_, EngineError>(mismatches(&whole, &picture))
    };
    assert_eq!(wrong("return Walk(", "return Walk(").unwrap(), 0);
    for (from, to) in [
        // The lowest bit of a colour; a forgotten opacity; another ray's pixel.
        (
            "select(image[pixel],",
            "select(bitcast<vec4<f32>>(bitcast<vec4<u32>>(image[pixel]) ^ vec4<u32>(1u, 0u, 0u, 0u)),",
        ),
        ("select(image[pixel],", "select(vec4<f32>(image[pixel].rgb, 0.0),"),
        ("next == 0u", "false"),
        // A sample left out, and one taken twice.
        ("= walk.next;", "= walk.next + u32(walk.next < ray_cut);"),
        ("= walk.next;", "= walk.next - u32(walk.next < ray_cut);"),
    ] {
        let found = wrong(from, to).unwrap();
        assert!(found > 100, "`{to}`: {found} pixels");
    }
    for (to, problem) in [
        // Rays that never begin, and rays that begin again and again.
        ("= select(0u, ray_cut, walk.next < ray_cut);", "though each took a single sample"),
        ("= select(walk.next, 0u, walk.next < ray_cut);", "rays make no headway"),
    ] {
        let error = wrong("= walk.next;", to).unwrap_err().to_string();
        assert!(error.contains(problem), "`{to}`: {error}");
    }
}

#[test]
fn slices_have_no_rays_to_cut() {
    let Some(device) = test_device("ray_pieces::slices") else { return };
    let volume = textured([9; 3], [1.0; 3], SampleType::U8);
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &volume);
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    let view = view(SampleType::U8, SIZE, Nearest);
    let plan = cvr::registry::renderer("slicing").unwrap().plan(&view, decoder.layout()).unwrap();
    let error = in_pieces(device, (&plan, &source, Nearest), 5).unwrap_err();
    assert!(matches!(error, EngineError::Unsupported(_)), "{error}");
}

/// Timestamps lie around all pieces. Their time agrees with the wall clock as it does at once.
#[test]
fn a_frame_in_pieces_has_the_time_of_all_of_them() {
    let Some(device) = test_device("ray_pieces::times") else { return };
    let volume = textured([32; 3], [1.0; 3], SampleType::U8);
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &volume);
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    let view = view(SampleType::U8, [96, 96], Linear);
    let plan = Raycasting.plan(&view, decoder.layout()).unwrap();
    let whole = Drawing::new(device, &plan, &source, Linear).unwrap();
    let pieces = Drawing::new(device, &plan, &source, Linear).unwrap().with_rays_in_pieces(1).unwrap();
    let [of_whole, of_pieces] = [&whole, &pieces].map(|drawing| {
        let times = (0..9).map(|_| drawing.draw_timed().unwrap());
        let mut stamps: Vec<f64> = times.filter_map(|time| time.gpu_ms).collect();
        stamps.sort_by(f64::total_cmp);
        stamps
    });
    println!("at once {of_whole:?} ms, in {} pieces {of_pieces:?} ms", pieces.ray_pieces().unwrap().pieces);
    if of_whole.len() > 4 {
        assert!(of_pieces.len() > 4, "{of_pieces:?}");
        // A single one of a hundred pieces would take far less.
        assert!(of_pieces[of_pieces.len() / 2] > 0.3 * of_whole[of_whole.len() / 2]);
    }
}
