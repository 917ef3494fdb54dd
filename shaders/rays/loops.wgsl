// Whether loops still run. After a device has ended a loop, no later loop runs twice. This loop must run twice.
// Compilers do not know its number of rounds, so they cannot remove it.
fn loops_run() -> bool {
    var rounds = 0u;
    while rounds * inputs.view.size.x <= inputs.view.size.x {
        rounds += 1u;
    }
    return rounds == 2u;
}
