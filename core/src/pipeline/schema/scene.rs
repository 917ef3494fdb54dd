//! `[[scene]]`

use super::shape::{Bounds, Key, Presence, Relation, Shape, Table};
use crate::pipeline::Scene;
use crate::render::{Camera, ColourOpacity, Light, Preset, Projection, Shading, TransferFunction};

/// A number of single precision as it was written.
fn single(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

fn word(name: &str, doc: &str) -> (String, String) {
    (name.to_owned(), doc.to_owned())
}

pub(super) fn table() -> Table {
    let side = || Shape::Integer { min: 1, max: i64::from(Scene::MAX_SIZE) };
    let share = || Shape::Number(Bounds::SHARE);
    let corner = || Shape::Tuple(vec![share(), share(), share()]);
    let (least, most) = (single(*Scene::STEP_VOXELS.start()), single(*Scene::STEP_VOXELS.end()));
    let domains = vec![
        word("data", "control values are data values"),
        word("range", "0 is the volume's lowest value, 1 its highest; named functions always are"),
    ];
    let opacities = ColourOpacity::NAMED.iter().map(|(name, meaning, _)| word(name, meaning)).collect();
    let frame = || Shape::Integer { min: 0, max: i64::from(u32::MAX) };
    let opacity = Bounds { above: Some(0.0), max: Some(1.0), ..Bounds::ANY };
    let keys = vec![
        Key::required("name", Shape::Name, "Name in records and files, unique even without regard to case"),
        Key::new(
            "volumes",
            Shape::Axis(Box::new(Shape::Text)),
            Presence::Absent("every volume that no scene names"),
            "The volumes that the scene is for",
        ),
        Key::with_default(
            "size",
            Shape::Tuple(vec![side(), side()]),
            "[256, 256]",
            "Width and height of the picture",
        )
        .unit("pixels"),
        Key::with_default("camera", Shape::Table(camera()), "{}", "From where"),
        Key::required(
            "transfer_function",
            transfer_function(),
            "Control points [value, \"#rrggbbaa\"] in ascending order, straight RGBA, the opacity that of one voxel \
             length; exactly linear in between, however narrow, and constant beyond. Two points of one value are a step, \
             at the value the later one holds. Or the name of a preset",
        ),
        Key::new(
            "transfer_function_domain",
            Shape::Words(domains),
            Presence::Absent("\"data\" for control points, \"range\" for a preset"),
            "What control values mean",
        ),
        Key::with_default(
            "opacity",
            Shape::Any(vec![Shape::Words(opacities), Shape::Table(opacity_table())]),
            "\"luminance\"",
            "What decides the opacity of colours; scalar volumes ignore it",
        ),
        Key::with_default(
            "frame",
            Shape::Any(vec![frame(), Shape::Tuple(vec![frame(), frame()])]),
            "0",
            "The frame that is drawn, counted from 0, or [first, last] of a range: each frame then has a picture of its \
             own, and the figures of a cell are pooled over them",
        ),
        Key::with_default(
            "shading",
            Shape::Any(vec![Shape::Boolean, Shape::Table(shading())]),
            "false",
            "How surfaces are lit: true for the default light, or a table",
        ),
        Key::with_default(
            "clip_box",
            Shape::Tuple(vec![corner(), corner()]),
            "[[0, 0, 0], [1, 1, 1]]",
            "What is drawn: lower and upper corner along x, y, z",
        )
        .unit("shares of the volume's extent"),
        Key::with_default(
            "step_voxels",
            Shape::Number(Bounds::range(least, most)),
            "0.5",
            "Distance between samples along a ray, or between slices",
        )
        .unit("voxels"),
        Key::with_default(
            "early_termination",
            Shape::Number(opacity),
            "0.999",
            "Opacity at which a ray ends; 1 = never. Slices have no such end",
        ),
        Key::with_default(
            "background",
            Shape::Colour { opacity: false },
            "\"#000000\"",
            "Colour behind the volume",
        ),
    ];
    let doc = "What a volume looks like: from where, in which colours, how large.";
    Table { relation: Some(Relation::TransferDomain), ..Table::new(doc, keys) }
}

fn transfer_function() -> Shape {
    let point = Shape::Tuple(vec![Shape::Number(Bounds::SINGLE), Shape::Colour { opacity: true }]);
    let presets = Preset::ALL.iter().map(|preset| word(preset.name, preset.doc)).collect();
    let list = Shape::List { item: Box::new(point), least: 2, most: Some(TransferFunction::MAX_POINTS) };
    Shape::Any(vec![Shape::Words(presets), list])
}

fn opacity_table() -> Table {
    let doc = "A volume file of 2³ to 64³ opacities from 0 to 1 of one voxel length, red along x, green along y, blue \
               along z; trilinear in between. In NumPy the index is [blue, green, red]";
    let keys = vec![Key::required("table", Shape::Path, doc)];
    Table::new("A table over all colours, from dark (first) to bright (last).", keys)
}

fn camera() -> Table {
    let default = Camera::default();
    let angle = || Shape::Number(Bounds::ANY);
    let projections =
        vec![word("perspective", "rays meet in the eye"), word("orthographic", "rays are parallel")];
    let projection = match default.projection {
        Projection::Perspective => "\"perspective\"",
        Projection::Orthographic => "\"orthographic\"",
    };
    let field = Bounds { above: Some(0.0), below: Some(180.0), ..Bounds::ANY };
    let number = |name: &str, shape, default: f64, doc: &str| {
        Key::with_default(name, shape, format!("{default:?}"), doc)
    };
    let elevation = Shape::Number(Bounds::range(-90.0, 90.0));
    let keys = vec![
        number(
            "azimuth",
            angle(),
            default.azimuth,
            "Turn of the eye around the z axis, counter-clockwise seen from above",
        )
        .unit("degrees"),
        number("elevation", elevation, default.elevation, "Height of the eye above the xy plane")
            .unit("degrees"),
        number("roll", angle(), default.roll, "Turn of the camera clockwise around its own axis")
            .unit("degrees"),
        number(
            "zoom",
            Shape::Number(Bounds::POSITIVE),
            default.zoom,
            "Magnification; 1 fits the volume's bounding sphere",
        ),
        Key::with_default("projection", Shape::Words(projections), projection, "Perspective or parallel"),
        number(
            "field_of_view",
            Shape::Number(field),
            default.field_of_view,
            "Angle across the shorter side of a perspective picture at zoom 1",
        )
        .unit("degrees"),
    ];
    Table::new("From where a scene is seen.", keys)
}

fn shading() -> Table {
    let default = Shading::default();
    let share = |name: &str, default: f32, doc: &str| {
        Key::with_default(name, Shape::Number(Bounds::SHARE), format!("{default:?}"), doc)
    };
    let exponents = Bounds::range(single(*Shading::SHININESS.start()), single(*Shading::SHININESS.end()));
    let lights = vec![
        word("camera", "the light moves with the viewer"),
        word("fixed", "the light stands still in the volume"),
    ];
    let light = match default.light {
        Light::Camera => "\"camera\"",
        Light::Fixed => "\"fixed\"",
    };
    let component = || Shape::Number(Bounds::SINGLE);
    let keys = vec![
        share("ambient", default.ambient, "Share of its colour that a sample shows without light"),
        share(
            "diffuse",
            default.diffuse,
            "Share of its colour that light adds where it meets the surface upright",
        ),
        share("specular", default.specular, "White that the highlight adds at its brightest"),
        Key::with_default(
            "shininess",
            Shape::Number(exponents),
            format!("{:?}", default.shininess),
            "Exponent of the highlight: the larger, the smaller it is",
        ),
        Key::with_default("light", Shape::Words(lights), light, "What the light's direction is bound to"),
        Key::with_default(
            "direction",
            Shape::Tuple(vec![component(), component(), component()]),
            format!("{:?}", default.direction),
            "Towards the light, of any length above 0: right, up, towards the viewer; with light = \"fixed\", along the \
             volume's axes",
        ),
    ];
    Table::new("How surfaces are lit.", keys)
}
