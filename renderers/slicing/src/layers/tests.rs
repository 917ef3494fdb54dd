//! Properties of a ring: every layer of a layer pair is in its slot when the pair is drawn, every slab is drawn with
//! every pair that it reaches into, and no layer is decoded twice.

use std::collections::BTreeSet;
use std::sync::Arc;

use cvr_core::render::{
    Camera, ClipBox, ControlPoint, Pass, Projection, Renderer, Shading, TransferFunction, View,
};
use cvr_core::volume::SampleType;

use super::*;

fn view(azimuth: f64, elevation: f64) -> View {
    let point = |value, alpha| ControlPoint { value, rgba: [1.0, 1.0, 1.0, alpha] };
    let function = TransferFunction::new(vec![point(0.0, 0.0), point(1.0, 1.0)]).unwrap();
    let camera = Camera { azimuth, elevation, projection: Projection::Orthographic, ..Camera::default() };
    View { size: [24, 24], camera, ..View::new(Arc::new(function)) }
}

fn layout(size: [u32; 3]) -> VolumeLayout {
    VolumeLayout {
        spacing: [1.0, 1.5, 0.7],
        ..VolumeLayout::scalar(size.try_into().unwrap(), SampleType::U8)
    }
}

fn pass(view: &View, layout: &VolumeLayout) -> Pass {
    let slicing = Slicing { geometry: Geometry::Axis, ..Slicing::default() };
    let plan = slicing.plan_layers(view, layout).unwrap();
    let [pass] = &plan.passes[..] else { panic!("one pass") };
    assert!(pass.pipeline.layers().is_some(), "layer by layer");
    pass.clone()
}

/// Checks the steps of a pass. Returns the numbers of the decoded layers in order.
fn decoded(pass: &Pass, view: &View, layout: &VolumeLayout) -> Result<Vec<u32>, String> {
    let layers = layout.extent.to_array()[pass.pipeline.layers().unwrap().index()] as i32;
    let reach = i32::from(view.shading.is_some());
    let (mut slots, mut buffer, mut decoded) = ([None; RING_LAYERS as usize], None, Vec::new());
    for step in &pass.inputs.steps {
        match step {
            LayerStep::Decode(layer) => {
                buffer = Some(*layer);
                decoded.push(*layer);
            }
            LayerStep::Place(slot) => slots[*slot as usize] = buffer,
            LayerStep::Draw { between, .. } => {
                for number in between - reach..=between + 1 + reach {
                    let wanted = Some(number.clamp(0, layers - 1) as u32);
                    let got = slots[number.rem_euclid(4) as usize];
                    if got != wanted {
                        return Err(format!("cell {between} reads layer {number} and finds {got:?}"));
                    }
                }
            }
        }
    }
    Ok(decoded)
}

/// Azimuth and elevation: all three axes, both ways.
const VIEWS: [(f64, f64); 6] =
    [(20.0, 10.0), (200.0, 10.0), (90.0, -10.0), (-90.0, 10.0), (0.0, 80.0), (0.0, -80.0)];

/// The axis along which a view runs, and whether in its positive direction, independent of the camera's conventions.
fn along(view: &View, layout: &VolumeLayout) -> (Axis, bool) {
    let rays = view.camera.rays(layout, view.size);
    let slabs = Slabs::new(Geometry::Axis, view, layout, &rays).unwrap();
    let axis = Axis::ALL.into_iter().find(|axis| slabs.normal[axis.index()] != 0.0).unwrap();
    (axis, slabs.normal[axis.index()] > 0.0)
}

#[test]
fn every_layer_is_there_when_it_is_read_and_decoded_once() {
    let mut seen = BTreeSet::new();
    for size in [[13, 17, 23], [1, 1, 1], [1, 9, 2], [3, 1, 40], [40, 3, 1]] {
        let layout = layout(size);
        for (azimuth, elevation) in VIEWS {
            for (step_voxels, shading) in
                [0.3, 1.0, 2.7, 50.0].into_iter().flat_map(|s| [(s, None), (s, Some(Shading::default()))])
            {
                let view = View { step_voxels, shading, ..view(azimuth, elevation) };
                let pass = pass(&view, &layout);
                let (axis, forwards) = along(&view, &layout);
                assert_eq!(pass.pipeline.layers().unwrap(), axis);
                seen.insert((axis, forwards));
                let mut all = decoded(&pass, &view, &layout).unwrap();
                all.sort_unstable();
                let layers: Vec<u32> = (0..size[axis.index()]).collect();
                assert_eq!(all, layers, "{size:?}, {azimuth}° {elevation}°, step {step_voxels}");
            }
        }
    }
    assert_eq!(seen.len(), 6, "three axes, both ways: {seen:?}");
}

/// The slices of a layer pair are those whose slabs contain a point of it, counted one by one in double precision.
#[test]
fn every_slab_is_drawn_with_every_cell_that_it_reaches_into() {
    let layout = layout([13, 17, 23]);
    for (azimuth, elevation) in VIEWS {
        for step_voxels in [0.3, 1.0, 2.7, 50.0] {
            let view = View { step_voxels, ..view(azimuth, elevation) };
            let pass = pass(&view, &layout);
            let rays = view.camera.rays(&layout, view.size);
            let slabs = Slabs::new(Geometry::Axis, &view, &layout, &rays).unwrap();
            let along = f64::from(slabs.normal[pass.pipeline.layers().unwrap().index()]);
            let layers = layout.extent.to_array()[pass.pipeline.layers().unwrap().index()];
            let mut cells = Vec::new();
            for step in &pass.inputs.steps {
                let LayerStep::Draw { between, vertices } = step else { continue };
                cells.push(*between);
                let drawn = &pass.inputs.vertices[vertices.start as usize..vertices.end as usize];
                let drawn: BTreeSet<u32> = drawn.iter().map(|vertex| vertex.slice).collect();
                // The part of the layer pair in the volume, from its lower to its upper end along the stack.
                let ends = [f64::from(*between) + 0.5, f64::from(*between) + 1.5];
                let ends = ends.map(|x| x.clamp(0.0, f64::from(layers)) * along);
                let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                for slice in 0..slabs.count {
                    let begin = f64::from(slabs.first) + f64::from(slice) * f64::from(slabs.thickness);
                    let reaches = begin < high - 1e-3 && begin + f64::from(slabs.thickness) > low + 1e-3;
                    assert!(!reaches || drawn.contains(&slice), "slice {slice} in cell {between}");
                }
            }
            let mut expected: Vec<i32> = (-1..layers as i32).collect();
            if along > 0.0 {
                expected.reverse();
            }
            assert_eq!(cells, expected, "back to front, each once");
        }
    }
}

#[test]
fn layers_that_no_sample_reads_are_not_decoded() {
    let layout = layout([13, 17, 23]);
    let clip = ClipBox { low: [0.0, 0.0, 0.4], high: [1.0, 1.0, 0.6] };
    for (azimuth, elevation) in VIEWS {
        let clipped = View { clip: Some(clip), ..view(azimuth, elevation) };
        let lit = View { shading: Some(Shading::default()), ..clipped.clone() };
        for (view, layers) in [(&clipped, 8..=14), (&lit, 7..=15)] {
            let pass = pass(view, &layout);
            let mut all = decoded(&pass, view, &layout).unwrap();
            all.sort_unstable();
            // The box holds 9.2 to 13.8 along z.
            let layers: Vec<u32> =
                if pass.pipeline.layers().unwrap() == Axis::Z { layers.collect() } else { continue };
            assert!(all.len() <= layers.len() && all.iter().all(|layer| layers.contains(layer)), "{all:?}");
            assert!(all.contains(&9) && all.contains(&13), "{all:?}");
        }
    }
}

/// The twin: rings that are wrong by one layer, or one slot, are detected.
#[test]
fn a_ring_that_is_off_by_one_is_noticed() {
    let layout = layout([13, 17, 23]);
    let view = View { shading: Some(Shading::default()), ..view(30.0, 20.0) };
    let right = pass(&view, &layout);
    assert!(decoded(&right, &view, &layout).is_ok());
    for (i, step) in right.inputs.steps.iter().enumerate() {
        let wrong = match step {
            LayerStep::Decode(layer) => LayerStep::Decode(layer + 1),
            LayerStep::Place(slot) => LayerStep::Place((slot + 1) % RING_LAYERS),
            LayerStep::Draw { .. } => continue,
        };
        let mut pass = right.clone();
        pass.inputs.steps[i] = wrong;
        assert!(decoded(&pass, &view, &layout).is_err(), "{step:?} at {i}");
    }
}

#[test]
fn other_geometries_are_refused_with_the_way_out() {
    for geometry in [Geometry::Planes, Geometry::Shells] {
        let slicing = Slicing { geometry, ..Slicing::default() };
        let layout = layout([4, 4, 4]);
        let error = slicing.plan_layers(&view(0.0, 0.0), &layout).unwrap_err();
        assert!(error.to_string().contains("use geometry axis"), "{error}");
    }
}
