//! Invalid numbers of stages, and invalid resolutions.

use super::*;

#[test]
fn numbers_of_stages() {
    const LINE: &str = "renderer = [\"raycasting\"]";
    let lines = ["0", "255", "1.5", "\"most\"", "[1, 2, 1]", "[]"].map(|v| format!("{LINE}\nstages = {v}"));
    let text = errors(&lines.each_ref().map(|line| (LINE, line.as_str())));
    insta::assert_snapshot!(text, @r#"
    error: expected an integer from 1 to 254, or "all", found `0`
       ┌─ x.toml:18:10
       │
    18 │ stages = 0
       │          ^ expected an integer from 1 to 254, or "all"

    error: expected an integer from 1 to 254, or "all", found `255`
       ┌─ x.toml:18:10
       │
    18 │ stages = 255
       │          ^^^ expected an integer from 1 to 254, or "all"

    error: expected an integer from 1 to 254, or "all", found a float
       ┌─ x.toml:18:10
       │
    18 │ stages = 1.5
       │          ^^^ expected an integer from 1 to 254, or "all"

    error: expected an integer from 1 to 254, or "all", found `"most"`
       ┌─ x.toml:18:10
       │
    18 │ stages = "most"
       │          ^^^^^^ expected an integer from 1 to 254, or "all"

    error: number of stages `1` is listed twice
       ┌─ x.toml:18:17
       │
    18 │ stages = [1, 2, 1]
       │           -     ^ again
       │           │
       │           first
       │
       = each would be drawn once: remove one of the two

    error: the list names no number of stages
       ┌─ x.toml:18:10
       │
    18 │ stages = []
       │          ^^ empty list
       │
       = name at least one number of stages
    "#);
}

#[test]
fn resolutions() {
    const LINE: &str = "renderer = [\"raycasting\"]";
    let lines = ["-1", "33", "[0, 0]"].map(|v| format!("{LINE}\nresolution = {v}"));
    let text = errors(&lines.each_ref().map(|line| (LINE, line.as_str())));
    insta::assert_snapshot!(text, @r#"
    error: expected an integer from 0 to 32, found `-1`
       ┌─ x.toml:18:14
       │
    18 │ resolution = -1
       │              ^^ expected an integer from 0 to 32

    error: expected an integer from 0 to 32, found `33`
       ┌─ x.toml:18:14
       │
    18 │ resolution = 33
       │              ^^ expected an integer from 0 to 32

    error: resolution `0` is listed twice
       ┌─ x.toml:18:18
       │
    18 │ resolution = [0, 0]
       │               -  ^ again
       │               │
       │               first
       │
       = each would be drawn once: remove one of the two
    "#);
}
