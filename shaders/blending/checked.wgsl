// What a fragment adds to the picture. A device may end loops that take it too many rounds, those of the codec among them,
// and go on behind them: such a fragment paints what is no light, and stays below zero under all fragments over it that do
// not hide it.
@fragment
fn blended(proxy: Proxy) -> @location(0) vec4<f32> {
    let colour = shown(proxy);
    if loops_run() {
        return colour;
    }
    return vec4<f32>(-6e4, -6e4, -6e4, 1.0);
}
