// The same, as hardware without powers approximates it (Guthe and Straßer 2001, section 4.1): the transparency T of one
// slice distance, to the power d, is interpolated between T and T², with the weight t(d) = 3/2 - 3/(d(d+1)) that makes
// the relative square error over all T least (their equation 2). Pieces shorter than a slice, at the border, lie
// between 1 and T.
fn slice_opacity(alpha: f32, piece: f32) -> f32 {
    let opacity = opacity_over(alpha, view.step);
    let d = piece / view.step;
    if d <= 1.0 {
        return opacity * d;
    }
    let transparency = 1.0 - opacity;
    let t = 1.5 - 3.0 / (d * (d + 1.0));
    return 1.0 - max(transparency + (transparency * transparency - transparency) * t, 0.0);
}
