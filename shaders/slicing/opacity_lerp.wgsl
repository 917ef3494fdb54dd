// As opacity_exact.wgsl, approximated for hardware without powers (Guthe and Straßer 2001, section 4.1). The opacity of
// d slice distances is interpolated between those of one and of two, α and 1 − (1 − α)². The weight t(d) minimises the
// squared error relative to α over all α: t(d) = 3(ψ(d + 2) − ψ(3)) with the digamma function ψ. Here it is a cubic,
// accurate to 0.0003 for d in 1..2. Pieces shorter than a slice, at the border, lie between 0 and α.
fn slice_opacity(alpha: f32, piece: f32) -> f32 {
    let opacity = opacity_over(alpha, inputs.view.step);
    let beyond = piece / inputs.view.step - 1.0;
    if beyond <= 0.0 {
        return opacity * (beyond + 1.0);
    }
    let t = beyond * (1.0 + (1.0 - beyond) * (0.18365 - 0.0385 * beyond));
    return min(opacity + (opacity - opacity * opacity) * t, 1.0);
}
