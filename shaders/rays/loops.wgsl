// Whether loops still run to their ends. A device that has ended one lets none behind it run twice, as this one must;
// how often it does no compiler knows, lest it be no loop.
fn loops_run() -> bool {
    var rounds = 0u;
    while rounds * inputs.view.size.x <= inputs.view.size.x {
        rounds += 1u;
    }
    return rounds == 2u;
}
