//! A command with placeholders. It runs without a shell, in its own process group, with a time limit.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use cvr_core::codec::Cancelled;
use cvr_core::volume::{Extent, SampleType};

/// Names of placeholders.
const PLACEHOLDERS: [&str; 7] = ["in", "out", "x", "y", "z", "type", "value"];

/// Interval at which a process is polled. It is too short to affect the time of one.
const POLL: Duration = Duration::from_millis(2);

/// Bytes of a failed command's messages that an error quotes.
const QUOTED: u64 = 400;

/// Why a text is not a command.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParseError {
    /// Quotes do not match.
    #[error("`{0}` leaves a quote open")]
    Quote(String),
    /// Nothing to run.
    #[error("it is empty")]
    Empty,
    /// An unknown placeholder.
    #[error(
        "`{{{0}}}` is no placeholder; there are {{in}}, {{out}}, {{x}}, {{y}}, {{z}}, {{type}} and {{value}}"
    )]
    Unknown(String),
    /// A command that cannot do anything.
    #[error("it lacks {{{0}}}, the path of the file that it is to {1}")]
    Missing(&'static str, &'static str),
}

/// Why a command did not do its work.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// It could not begin.
    #[error("`{0}` cannot be run: {1}")]
    Start(String, std::io::Error),
    /// It ended with an error.
    #[error("`{command}` ended with {status}{said}")]
    Failed {
        /// As it was run.
        command: String,
        /// How it ended.
        status: ExitStatus,
        /// The end of its messages.
        said: String,
    },
    /// It took too long.
    #[error("`{0}` was killed after {1} s; raise timeout_seconds if it needs longer")]
    TimedOut(String, u64),
    /// The user asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// Files around it.
    #[error("{0}: {1}")]
    File(String, std::io::Error),
}

/// Description of the samples in a file, for a command.
#[derive(Copy, Clone, Debug)]
pub struct Field {
    /// Voxels.
    pub extent: Extent,
    /// Type of the samples, little-endian, x fastest.
    pub sample: SampleType,
}

/// A command that was read.
#[derive(Clone, Debug)]
pub struct Command {
    text: String,
    words: Vec<String>,
    value: f64,
    timeout: Duration,
}

impl Command {
    /// Splits a command into words as a shell would, and checks its placeholders.
    ///
    /// # Errors
    /// When it is no command; the message says where.
    pub fn parse(text: &str, value: f64, timeout: Duration) -> Result<Self, ParseError> {
        let words = shlex::split(text).ok_or_else(|| ParseError::Quote(text.to_owned()))?;
        if words.is_empty() {
            return Err(ParseError::Empty);
        }
        let named: Vec<&str> = words.iter().flat_map(|word| placeholders(word)).collect();
        if let Some(unknown) = named.iter().find(|name| !PLACEHOLDERS.contains(name)) {
            return Err(ParseError::Unknown((*unknown).to_owned()));
        }
        for (name, does) in [("in", "read"), ("out", "write")] {
            if !named.contains(&name) {
                return Err(ParseError::Missing(name, does));
            }
        }
        Ok(Self { text: text.to_owned(), words, value, timeout })
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Replacement of `{value}`.
    pub const fn value(&self) -> f64 {
        self.value
    }

    /// How long it may run.
    pub const fn timeout(&self) -> Duration {
        self.timeout
    }

    /// Runs the command on two files and waits. `go_on` is called while it runs. Messages of the command go to a file
    /// in `folder`.
    ///
    /// # Errors
    /// When it cannot begin, fails, takes too long, or `go_on` says that the user asked to stop; whatever it has started
    /// is killed then.
    pub fn run(
        &self,
        field: Field,
        [input, output]: [&Path; 2],
        folder: &Path,
        go_on: impl Fn() -> Result<(), Cancelled>,
    ) -> Result<(), RunError> {
        let words: Vec<String> =
            self.words.iter().map(|word| self.filled(word, field, input, output)).collect();
        let shown = shlex::try_join(words.iter().map(String::as_str)).unwrap_or_else(|_| self.text.clone());
        let messages = folder.join("messages");
        let file = |e| RunError::File(messages.display().to_string(), e);
        // The one before may have left anything under this name.
        _ = std::fs::remove_file(&messages);
        let said = File::options().read(true).write(true).create_new(true).open(&messages).map_err(file)?;
        let kept = said.try_clone().map_err(file)?;
        let mut process = std::process::Command::new(&words[0]);
        process.args(&words[1..]).stdin(Stdio::null()).stdout(said.try_clone().map_err(file)?).stderr(said);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut process, 0);
        let start = Instant::now();
        let mut child = Running(process.spawn().map_err(|e| RunError::Start(shown.clone(), e))?);
        loop {
            if let Some(status) = child.0.try_wait().map_err(|e| RunError::Start(shown.clone(), e))? {
                let said = if status.success() { String::new() } else { last_words(kept) };
                return if status.success() {
                    Ok(())
                } else {
                    Err(RunError::Failed { command: shown, status, said })
                };
            }
            if go_on().is_err() {
                return Err(RunError::Cancelled);
            }
            if start.elapsed() > self.timeout {
                return Err(RunError::TimedOut(shown, self.timeout.as_secs()));
            }
            std::thread::sleep(POLL);
        }
    }

    fn filled(&self, word: &str, field: Field, input: &Path, output: &Path) -> String {
        let [x, y, z] = field.extent.to_array();
        let mut filled = String::new();
        let mut rest = word;
        while let Some((before, name, after)) = next_placeholder(rest) {
            filled += before;
            match name {
                "in" => filled += &input.to_string_lossy(),
                "out" => filled += &output.to_string_lossy(),
                "x" => filled += &x.to_string(),
                "y" => filled += &y.to_string(),
                "z" => filled += &z.to_string(),
                "type" => filled += field.sample.name(),
                _ => filled += &self.value.to_string(),
            }
            rest = after;
        }
        filled + rest
    }
}

/// A process that does not outlive its owner.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        if matches!(self.0.try_wait(), Ok(Some(_))) {
            return;
        }
        #[cfg(unix)]
        if let Some(group) = i32::try_from(self.0.id()).ok().and_then(rustix::process::Pid::from_raw) {
            // The whole group, else child processes of a script would go on.
            _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// The first placeholder of a text: the text before it, its name, the text after it. Braces around anything but small
/// letters are ordinary text.
fn next_placeholder(text: &str) -> Option<(&str, &str, &str)> {
    let mut from = 0;
    while let Some(open) = text[from..].find('{').map(|at| from + at) {
        let name = &text[open + 1..];
        let end = name.find(|c: char| !c.is_ascii_lowercase()).unwrap_or(name.len());
        if end > 0 && name[end..].starts_with('}') {
            return Some((&text[..open], &name[..end], &name[end + 1..]));
        }
        from = open + 1;
    }
    None
}

fn placeholders(word: &str) -> impl Iterator<Item = &str> {
    let mut rest = word;
    std::iter::from_fn(move || {
        let (_, name, after) = next_placeholder(rest)?;
        rest = after;
        Some(name)
    })
}

/// The end of a command's messages, as one line.
fn last_words(mut file: File) -> String {
    let read = || -> std::io::Result<String> {
        use std::io::{Seek, SeekFrom};
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(QUOTED)))?;
        let mut bytes = Vec::new();
        file.take(QUOTED).read_to_end(&mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).split_whitespace().collect::<Vec<_>>().join(" "))
    };
    match read() {
        Ok(said) if !said.is_empty() => format!(": {said}"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINUTE: Duration = Duration::from_secs(60);

    fn field() -> Field {
        Field { extent: Extent::new(3, 4, 5).unwrap(), sample: SampleType::I16 }
    }

    #[test]
    fn placeholders_are_filled_word_by_word() {
        let text = "tool --size={x}x{y}x{z} '{in}' -t {type} -v {value} ${HOME} {} {out}";
        let command = Command::parse(text, 0.25, MINUTE).unwrap();
        let fill = |word: &String| command.filled(word, field(), Path::new("a b"), Path::new("c"));
        let words: Vec<_> = command.words.iter().map(fill).collect();
        assert_eq!(words, ["tool", "--size=3x4x5", "a b", "-t", "i16", "-v", "0.25", "${HOME}", "{}", "c"]);
    }

    #[test]
    fn what_is_no_command_is_refused() {
        let problem = |text| Command::parse(text, 0.0, MINUTE).unwrap_err();
        assert_eq!(problem(" "), ParseError::Empty);
        assert_eq!(problem("cp 'x {in}"), ParseError::Quote("cp 'x {in}".to_owned()));
        assert_eq!(problem("cp {in} {output}"), ParseError::Unknown("output".to_owned()));
        assert_eq!(problem("cp {in} x"), ParseError::Missing("out", "write"));
        assert!(
            problem("cp {out}").to_string().contains("lacks {in}, the path of the file that it is to read")
        );
    }

    #[cfg(unix)]
    #[test]
    fn failures_quote_what_was_said() {
        let folder = tempfile::tempdir().unwrap();
        let run = |text: &str, timeout| {
            let command = Command::parse(text, 0.0, timeout).unwrap();
            command.run(field(), [Path::new("x"), Path::new("y")], folder.path(), || Ok(())).unwrap_err()
        };
        let failed = run("sh -c 'echo {in} is bad >&2; exit 7 # {out}'", MINUTE).to_string();
        assert!(failed.contains("exit status: 7: x is bad"), "{failed}");
        let missing = run("no-such-program {in} {out}", MINUTE).to_string();
        assert!(missing.starts_with("`no-such-program x y` cannot be run: "), "{missing}");
    }

    /// A child of the script is killed with it. Otherwise it would write the file after a second.
    #[cfg(unix)]
    #[test]
    fn a_command_that_takes_too_long_is_killed_with_its_children() {
        let folder = tempfile::tempdir().unwrap();
        let late = folder.path().join("late");
        let text = "sh -c '(sleep 1; touch {out}) & sleep 60 # {in}'";
        let command = Command::parse(text, 0.0, Duration::from_millis(200)).unwrap();
        let problem = command.run(field(), [Path::new("x"), &late], folder.path(), || Ok(())).unwrap_err();
        assert!(matches!(problem, RunError::TimedOut(..)), "{problem}");
        let command = Command::parse(text, 0.0, MINUTE).unwrap();
        let problem =
            command.run(field(), [Path::new("x"), &late], folder.path(), || Err(Cancelled)).unwrap_err();
        assert!(matches!(problem, RunError::Cancelled), "{problem}");
        std::thread::sleep(Duration::from_millis(1500));
        assert!(!late.exists());
    }
}
