//! Hostile files: seeded edits of bytes, texts and JSON; and the harness that detects panics and hangs.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use serde_json::Value;

/// Longest time of one case, in an unoptimised build on a busy machine.
const LONGEST: Duration = Duration::from_secs(60);

/// A sequence of random numbers from a seed: splitmix64.
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`. 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.roll() % n.max(1) as u64) as usize
    }

    pub fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// Number of cases of a campaign: `CVR_HOSTILE`, or `usual`, which fits a test run.
pub fn cases(usual: u64) -> u64 {
    match std::env::var("CVR_HOSTILE") {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("CVR_HOSTILE={text}: a number of cases")),
        Err(_) => usual,
    }
}

/// Runs the cases of a campaign. A case that panics or returns an error is reported with its seed. A case that hangs
/// ends the process, because nothing else can stop it.
pub fn campaign<E: Display>(name: &'static str, usual: u64, mut case: impl FnMut(Dice) -> Result<bool, E>) {
    let (start, cases) = (Instant::now(), cases(usual));
    let (begun, watched) = mpsc::channel::<u64>();
    std::thread::spawn(move || {
        let mut seed = 0;
        loop {
            match watched.recv_timeout(LONGEST) {
                Ok(next) => seed = next,
                Err(mpsc::RecvTimeoutError::Disconnected) => return,
                Err(mpsc::RecvTimeoutError::Timeout) => {
                    eprintln!("{name}: case {seed} takes more than {LONGEST:?}");
                    std::process::exit(101);
                }
            }
        }
    });
    let (mut accepted, mut wrong) = (0, Vec::new());
    for seed in 0..cases {
        let _ = begun.send(seed);
        match catch_unwind(AssertUnwindSafe(|| case(Dice::new(seed)))) {
            Ok(Ok(is_accepted)) => accepted += u64::from(is_accepted),
            Ok(Err(problem)) => wrong.push(format!("case {seed}: {problem}")),
            Err(_) => wrong.push(format!("case {seed} panics")),
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{name}: {cases} cases, {accepted} accepted, {} wrong, {seconds:.1} s", wrong.len());
    wrong.truncate(20);
    assert!(wrong.is_empty(), "{name}:\n{}", wrong.join("\n"));
    // If all cases were refused at once, later code would not be tested.
    assert!(accepted > 0 && accepted < cases, "{name}: {accepted} of {cases} accepted");
}

/// Numbers that programs stumble over, as texts write them.
const NUMBERS: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "3",
    "7",
    "255",
    "256",
    "32768",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "99999999999999999999999",
    "-2147483649",
    "0.5",
    "-0.0",
    "1e-45",
    "1e38",
    "1e39",
    "1e309",
    "-1e309",
    "nan",
    "inf",
    "0x10",
    "1_0",
    "",
];

/// One to four edits. Spliced-in bytes come from `other`.
pub fn bytes(dice: &mut Dice, bytes: &mut Vec<u8>, other: &[u8]) {
    for _ in 0..=dice.below(4) {
        if bytes.is_empty() {
            return;
        }
        // Headers are short and hold most of the meaning, so they get half of the edits.
        let reach = if dice.below(2) == 0 { bytes.len().min(512) } else { bytes.len() };
        let at = dice.below(reach);
        let run = 1 + dice.below(16.min(bytes.len() - at));
        match dice.below(9) {
            0 | 1 => bytes[at] ^= 1 << dice.below(8),
            2 => bytes[at] = dice.roll() as u8,
            3 => bytes.truncate(at),
            4 => {
                let more = 1 + dice.below(64);
                bytes.extend((0..more).map(|_| dice.roll() as u8));
            }
            5 => bytes[at..at + run].fill(*dice.pick(&[0, 0xff, b' '])),
            6 => drop(bytes.drain(at..at + run)),
            7 if !other.is_empty() => {
                let from = dice.below(other.len());
                let piece = &other[from..other.len().min(from + 1 + dice.below(200))];
                bytes.splice(at..at + run, piece.iter().copied());
            }
            _ => number(dice, bytes, at),
        }
    }
}

/// The next digits from a place on become another number.
fn number(dice: &mut Dice, bytes: &mut Vec<u8>, at: usize) {
    let Some(start) = (at..bytes.len().min(at + 400)).find(|&i| bytes[i].is_ascii_digit()) else { return };
    let end = (start..bytes.len()).find(|&i| !bytes[i].is_ascii_digit()).unwrap_or(bytes.len());
    let number = dice.pick(NUMBERS).as_bytes();
    bytes.splice(start..end, number.iter().copied());
}

/// One to four edits of a text of lines: its words, numbers, lines and nesting.
pub fn text(dice: &mut Dice, text: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..=dice.below(4) {
        if lines.is_empty() {
            break;
        }
        let (at, other) = (dice.below(lines.len()), dice.below(lines.len()));
        match dice.below(8) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[other].clone()),
            2 => lines.swap(at, other),
            3 | 4 => {
                let mut line = std::mem::take(&mut lines[at]).into_bytes();
                number(dice, &mut line, 0);
                lines[at] = String::from_utf8_lossy(&line).into_owned();
            }
            5 => {
                let words: Vec<String> =
                    lines[other].split_inclusive([' ', ',', '[', ']', '=']).map(str::to_owned).collect();
                let mut own: Vec<String> =
                    lines[at].split_inclusive([' ', ',', '[', ']', '=']).map(str::to_owned).collect();
                if let (false, false) = (own.is_empty(), words.is_empty()) {
                    let place = dice.below(own.len());
                    own[place] = dice.pick(&words).clone();
                }
                lines[at] = own.concat();
            }
            6 => {
                let depth = 1 + dice.below(60);
                if let Some((key, value)) = lines[at].clone().split_once('=') {
                    lines[at] = format!("{key}={}{value}{}", "[".repeat(depth), "]".repeat(depth));
                }
            }
            _ => {
                let mut line = std::mem::take(&mut lines[at]).into_bytes();
                bytes(dice, &mut line, b"[[]]{}\"'\\u0000\xff#=,.");
                lines[at] = String::from_utf8_lossy(&line).into_owned();
            }
        }
    }
    lines.join("\n")
}

/// Changes, removes or doubles a value anywhere below `root`.
pub fn json(dice: &mut Dice, root: &mut Value) {
    let mut at = root;
    loop {
        let inner = match &*at {
            Value::Array(items) => items.len(),
            Value::Object(fields) => fields.len(),
            _ => 0,
        };
        // Most values lie deep, so the walk rarely stops above them.
        if inner == 0 || dice.below(12) == 0 {
            break;
        }
        let i = dice.below(inner);
        let own = at;
        at = match own {
            Value::Array(items) => &mut items[i],
            Value::Object(fields) => fields.values_mut().nth(i).unwrap(),
            _ => unreachable!("it has inner values"),
        };
    }
    match (dice.below(6), &mut *at) {
        (0, Value::Array(items)) if !items.is_empty() => drop(items.pop()),
        (1, Value::Array(items)) if !items.is_empty() => items.push(items[0].clone()),
        (0 | 1, Value::Object(fields)) if !fields.is_empty() => {
            let key = fields.keys().nth(dice.below(fields.len())).unwrap().clone();
            fields.remove(&key);
        }
        (2, Value::Object(fields)) => {
            fields.insert("unknown".to_owned(), 1.into());
        }
        (3, Value::Number(n)) if n.is_i64() || n.is_u64() => {
            let near = [1_i64, -1, 2, -2, 8, 64];
            *at = n.as_i64().map_or(Value::Null, |n| n.wrapping_add(*dice.pick(&near)).into());
        }
        (3, Value::Number(n)) => {
            let value = n.as_f64().unwrap_or(0.0);
            *at = (value * dice.pick(&[-1.0, 0.0, 1e20, 1e-20, 1.0000001])).into();
        }
        (4, Value::String(text)) => {
            let mut edited = std::mem::take(text).into_bytes();
            bytes(dice, &mut edited, b"../\0<script>\"; ,=x");
            *at = String::from_utf8_lossy(&edited).into_owned().into();
        }
        _ => *at = dice.pick(&strange()).clone(),
    }
}

/// Values that programs stumble over.
fn strange() -> Vec<Value> {
    let numbers = [
        0,
        1,
        -1,
        2,
        3,
        31,
        32,
        33,
        255,
        65535,
        65536,
        i64::from(i32::MAX),
        i64::from(u32::MAX),
        1 << 32,
        i64::MAX,
        i64::MIN,
    ];
    let floats = [0.5, -0.5, 1e-45, 1e-38, 3.4e38, 1e39, 1e300, -1e300];
    let texts = ["", "x", "4096", "NaN", "../../x", "8x8", "0x0x0", "a=b c='d"];
    let mut all: Vec<Value> = numbers.into_iter().map(Value::from).collect();
    all.extend(floats.map(Value::from));
    all.extend(texts.map(Value::from));
    all.extend([Value::Null, true.into(), u64::MAX.into(), Value::Array(vec![]), serde_json::json!({})]);
    all
}

#[test]
fn the_same_seed_makes_the_same_file() {
    let edited = |seed| {
        let mut file = b"NRRD0004\nsizes: 4 4 4\n\n0123456789".to_vec();
        bytes(&mut Dice::new(seed), &mut file, b"other");
        let mut value = serde_json::json!({"a": [1, 2.5], "b": {"c": "d"}});
        json(&mut Dice::new(seed), &mut value);
        (file, text(&mut Dice::new(seed), "a = 1\nb = [2, 3]\n"), value)
    };
    assert_eq!(edited(7), edited(7));
    let all: Vec<_> = (0..50).map(edited).collect();
    assert!(all.iter().filter(|one| **one == all[0]).count() < 5, "seeds make files of their own");
}

/// The failing twins of the harness.
#[test]
fn a_campaign_tells_panics_and_problems_with_their_seeds() {
    let told = |case: fn(Dice) -> Result<bool, String>| {
        let ran = catch_unwind(|| campaign("twin", 3, case)).unwrap_err();
        ran.downcast_ref::<String>().cloned().unwrap_or_default()
    };
    if std::env::var_os("CVR_HOSTILE").is_some() {
        return;
    }
    let sorted = |mut dice: Dice| Ok(dice.roll().is_multiple_of(2));
    assert!(
        told(|dice| if dice.0 == 1 { panic!("on purpose") } else { Ok(dice.0 == 0) })
            .contains("case 1 panics")
    );
    assert!(
        told(|dice| if dice.0 == 2 { Err("odd".to_owned()) } else { Ok(dice.0 == 0) })
            .contains("case 2: odd")
    );
    assert!(told(|_| Ok(false)).contains("0 of 3 accepted"));
    campaign::<String>("twin", 40, sorted);
}
