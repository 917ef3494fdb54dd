//! The pass that draws a view from a ring of four decoded layers: deferred filtering after Fout and Ma (2007, section
//! 5). The stack lies along the volume's main axis. Layers are decoded as the slices need them.
//!
//! Samples are grouped by *layer pair*: the space between the centres of two neighbouring layers. Pairs are drawn in
//! the order of slices, so every ray meets them in that order. A slab that reaches over several pairs is drawn with
//! each of them, and the shader takes each sample only with its own pair. So any step is possible.

use std::ops::Range;

use cvr_core::render::{LayerStep, Macrocells, Plan, ProxyVertex, RING_LAYERS, RenderError, Stage, View};
use cvr_core::volume::{Axis, VolumeLayout};

use crate::modules::SLICES_BY_LAYERS;
use crate::plan::slices;
use crate::slabs::Slabs;
use crate::{Geometry, Slicing};

/// Layer pairs are enlarged by this many voxels at either end when slabs that reach into them are searched. It is far
/// more than the rounding of a position in single precision.
const MARGIN: f32 = 0.0625;

pub fn plan(slicing: &Slicing, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
    if slicing.geometry != Geometry::Axis {
        return Err(RenderError::Unsupported(
            "renderer slicing draws layer by layer only where its slices lie across an axis of the volume; use \
             geometry axis"
                .to_owned(),
        ));
    }
    let stage = |slabs: &Slabs, proxies| Stage::Layers { proxies, axis: axis_of(slabs) };
    let (slabs, mut pass) = slices(slicing, view, layout, SLICES_BY_LAYERS, stage)?;
    pass.inputs.steps = Stack::new(&slabs, view, layout).steps(&slabs, &pass.inputs.vertices);
    Ok(Plan { size: view.size, passes: vec![pass] })
}

/// The volume's axis along which a stack lies.
fn axis_of(slabs: &Slabs) -> Axis {
    Axis::ALL.into_iter().find(|axis| slabs.normal[axis.index()] != 0.0).unwrap_or(Axis::Z)
}

/// The layers of a volume along the axis of a stack, and the part that a view reads.
struct Stack {
    axis: Axis,
    layers: i32,
    /// The layer pairs that hold samples, by the lower layer. −1 is the half voxel below the first layer's centre; the
    /// last layer's number is the half voxel above its centre.
    cells: Range<i32>,
    /// Number of layers that a sample of a layer pair reads on each side of the pair.
    reach: i32,
    /// Whether anything shows in each row of macrocells along the axis. `None` without skipping.
    shows: Option<Vec<bool>>,
}

impl Stack {
    fn new(slabs: &Slabs, view: &View, layout: &VolumeLayout) -> Self {
        let axis = axis_of(slabs);
        let a = axis.index();
        let layers = layout.extent.to_array()[a] as i32;
        let [low, high] = view.bounds(layout.extent).map(|corner| corner[a]);
        let first = ((low - MARGIN - 0.5).floor() as i32).max(-1);
        let last = ((high + MARGIN - 0.5).floor() as i32).min(layers - 1);
        let shows = view.skippable(layout).map(|macrocells| rows_that_show(macrocells, a));
        Self { axis, layers, cells: first..last + 1, reach: i32::from(view.shading.is_some()), shows }
    }

    /// The steps that decode and draw, the farthest layer pair first.
    fn steps(&self, slabs: &Slabs, vertices: &[ProxyVertex]) -> Vec<LayerStep> {
        let along = slabs.normal[self.axis.index()];
        let farthest_first = |range: Range<i32>| {
            let mut numbers: Vec<i32> = range.collect();
            if along > 0.0 {
                numbers.reverse();
            }
            numbers
        };
        let mut filling = Filling::default();
        for cell in farthest_first(self.cells.clone()) {
            let vertices = of_cell(slabs, vertices, along, cell);
            if !vertices.is_empty() && self.may_show(cell) {
                let read = cell - self.reach..cell + 2 + self.reach;
                farthest_first(read).into_iter().for_each(|number| filling.hold(number, self.layers));
                filling.steps.push(LayerStep::Draw { between: cell, vertices });
            }
        }
        filling.steps
    }

    /// Whether a macrocell with samples of a layer pair shows anything.
    fn may_show(&self, cell: i32) -> bool {
        let Some(rows) = &self.shows else { return true };
        let row = |x: f32| ((x / Macrocells::EDGE as f32).floor().max(0.0) as usize).min(rows.len() - 1);
        let low = cell as f32 + 0.5;
        rows[row(low - MARGIN)..=row(low + 1.0 + MARGIN)].contains(&true)
    }
}

fn rows_that_show(macrocells: &Macrocells, axis: usize) -> Vec<bool> {
    let grid = macrocells.grid();
    let mut rows = vec![false; grid.to_array()[axis] as usize];
    for at in (0..grid.voxels() as usize).map(|i| grid.position(i)) {
        rows[at[axis] as usize] |= macrocells.shows(at);
    }
    rows
}

/// The vertices of the slabs that reach into a layer pair. Slabs are counted along the stack's direction, which is
/// `along` times an axis of the volume. The vertices begin with the last slab.
fn of_cell(slabs: &Slabs, vertices: &[ProxyVertex], along: f32, cell: i32) -> Range<u32> {
    let at = |x: f32| (along * x - slabs.first) / slabs.thickness;
    let (a, b) = (at(cell as f32 + 0.5 - MARGIN), at(cell as f32 + 1.5 + MARGIN));
    let (begin, end) = (a.min(b).floor(), a.max(b).floor());
    let before = |slice: f32| vertices.partition_point(|vertex| vertex.slice as f32 > slice) as u32;
    before(end)..before(begin - 1.0)
}

/// The steps so far, and the resulting content of the ring and of the buffer of one layer.
#[derive(Default)]
struct Filling {
    steps: Vec<LayerStep>,
    slots: [Option<u32>; RING_LAYERS as usize],
    decoded: Option<u32>,
}

impl Filling {
    /// Ensures that a layer is in its slot. Beyond the border it is the outermost layer. Calls are in the order of
    /// layer pairs, so the outermost layer is still in the buffer when it is placed again.
    fn hold(&mut self, number: i32, layers: i32) {
        let layer = number.clamp(0, layers - 1) as u32;
        let slot = number.rem_euclid(RING_LAYERS as i32) as u32;
        if self.slots[slot as usize] == Some(layer) {
            return;
        }
        if self.decoded != Some(layer) {
            self.steps.push(LayerStep::Decode(layer));
            self.decoded = Some(layer);
        }
        self.steps.push(LayerStep::Place(slot));
        self.slots[slot as usize] = Some(layer);
    }
}

#[cfg(test)]
mod tests;
