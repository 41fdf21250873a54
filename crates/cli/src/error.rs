//! Errors and warnings of the command: message and hint are separate, and printed by one function.

use std::fmt;
use std::path::Path;

use qrm_pictures::NoPlace;
use qrm_scene::diagnostic::{Diagnostic, Report};
use serde::{Serialize, Serializer};

/// A problem in one sentence, and its remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    /// The problem, in one sentence.
    pub(crate) text: String,
    /// The remedy.
    pub(crate) help: Option<String>,
}

/// The line that separates a hint from its message.
const HELP: &str = "\n  = help: ";

impl Message {
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), help: None }
    }

    #[must_use]
    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds a prefix to the message.
    #[must_use]
    pub(crate) fn after(mut self, prefix: &str) -> Self {
        self.text.insert_str(0, prefix);
        self
    }

    /// The message and its hint.
    pub(crate) fn lines(&self) -> Vec<String> {
        std::iter::once(&self.text).chain(&self.help).cloned().collect()
    }

    /// The message as a warning.
    pub(crate) fn warning(&self) -> String {
        format!("warning: {self}")
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)?;
        self.help.iter().try_for_each(|help| write!(f, "{HELP}{help}"))
    }
}

impl Serialize for Message {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The reason why a command failed.
#[derive(Debug)]
pub struct Error {
    kind: Kind,
    details: Vec<Detail>,
}

/// A problem and its location in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The path of the scene file, as the user typed it.
    pub path: String,
    /// Line and column of the first character, counted from 1; `None` for the whole file.
    pub place: Option<[usize; 2]>,
    /// The problem, in one sentence.
    pub text: String,
    /// The remedy.
    pub help: Option<String>,
}

/// The kind of an error, which determines the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The run itself failed; its files show how far it got.
    Run,
    /// The command line or the scene has an error.
    Usage,
}

/// A part of an error.
#[derive(Debug)]
enum Detail {
    Message(Message),
    /// Errors at locations in a text.
    Places(Report),
}

impl Error {
    /// Creates the error of an invalid option or scene.
    pub fn usage(text: impl Into<String>) -> Self {
        Self { kind: Kind::Usage, details: vec![Detail::Message(Message::new(text))] }
    }

    /// Creates the error of a repeated option, such as `--set O2A`.
    pub(crate) fn given_twice(option: &str) -> Self {
        Self::usage(format!("`{option}` is given twice")).help("keep one of the two")
    }

    /// Creates the error of a failed run.
    pub(crate) fn run(text: impl Into<String>) -> Self {
        Message::new(text).into()
    }

    /// Creates the error of a file that cannot be written.
    pub(crate) fn unwritable(path: &Path, e: &std::io::Error) -> Self {
        if e.kind() == std::io::ErrorKind::WouldBlock {
            return Self::usage(format!("another command is writing {}", path.display()))
                .help("wait for its end, or choose another place with --out");
        }
        let is_no_folder = |above: &&Path| above.exists() && !above.is_dir();
        let reason = match path.ancestors().skip(1).find(is_no_folder) {
            Some(above) => format!("{} is not a folder", above.display()),
            None => e.to_string(),
        };
        Self::usage(format!("cannot write {}: {reason}", path.display())).help("choose another folder with --out DIR")
    }

    /// Creates the error of a file that cannot be read.
    pub(crate) fn unreadable(path: &Path, e: &std::io::Error) -> Self {
        Self::usage(format!("cannot read {}: {e}", path.display()))
    }

    /// Adds a remedy.
    #[must_use]
    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        if let Some(Detail::Message(message)) = self.details.last_mut() {
            message.help = Some(help.into());
        }
        self
    }

    /// Puts a message with its remedy before the error.
    #[must_use]
    pub(crate) fn behind(mut self, text: impl Into<String>, help: impl Into<String>) -> Self {
        self.details.insert(0, Detail::Message(Message::new(text).help(help)));
        self
    }

    /// Turns the error into one of a run in progress.
    #[must_use]
    pub(crate) fn while_running(self) -> Self {
        Self { kind: Kind::Run, ..self }
    }

    /// Joins several errors into one of a run, if there are any.
    pub(crate) fn all(errors: Vec<Self>) -> Result<(), Self> {
        if errors.is_empty() {
            return Ok(());
        }
        Err(Self { kind: Kind::Run, details: errors.into_iter().flat_map(|error| error.details).collect() })
    }

    /// Whether a run failed, as opposed to a wrong use of the command or an invalid scene.
    pub fn is_of_run(&self) -> bool {
        self.kind == Kind::Run
    }

    /// The problems in the text of a scene.
    pub fn findings(&self) -> Vec<Finding> {
        let reports = self.details.iter().filter_map(|detail| match detail {
            // The value of an option is a text too, but not a scene.
            Detail::Places(report) if !report.path.starts_with("--") => Some(report),
            _ => None,
        });
        reports.flat_map(Finding::from_report).collect()
    }

    /// The remedies.
    pub fn hints(&self) -> Vec<String> {
        let hints = self.details.iter().flat_map(|detail| match detail {
            Detail::Message(message) => vec![message.help.clone()],
            Detail::Places(report) => report.diagnostics.iter().map(|found| found.help.clone()).collect(),
        });
        hints.flatten().collect()
    }

    /// The exit status of the command.
    pub(crate) fn status(&self) -> u8 {
        match self.kind {
            Kind::Run => 1,
            Kind::Usage => 2,
        }
    }

    /// The first message, without its location.
    pub(crate) fn message(self) -> Message {
        match self.details.into_iter().next() {
            Some(Detail::Message(message)) => message,
            Some(Detail::Places(mut report)) if !report.diagnostics.is_empty() => {
                let found = report.diagnostics.swap_remove(0);
                Message { text: found.title, help: found.help }
            }
            _ => Message::new(""),
        }
    }
}

impl Finding {
    fn from_report(report: &Report) -> Vec<Self> {
        let place = |start: usize| {
            let before = report.source.get(..start)?;
            let line = before.rsplit('\n').next().unwrap_or_default();
            Some([before.matches('\n').count() + 1, line.chars().count() + 1])
        };
        let finding = |found: &Diagnostic| Self {
            path: report.path.clone(),
            place: found.span.as_ref().and_then(|span| place(span.start)),
            text: found.title.clone(),
            help: found.help.clone(),
        };
        report.diagnostics.iter().map(finding).collect()
    }
}

impl std::error::Error for Error {}

impl From<Message> for Error {
    fn from(message: Message) -> Self {
        Self { kind: Kind::Run, details: vec![Detail::Message(message)] }
    }
}

impl From<NoPlace> for Message {
    fn from(reason: NoPlace) -> Self {
        Self::new(reason.to_string()).help("look for divisions by zero, roots and logarithms in its formula")
    }
}

impl From<NoPlace> for Error {
    fn from(reason: NoPlace) -> Self {
        Message::from(reason).into()
    }
}

impl From<Report> for Error {
    fn from(report: Report) -> Self {
        Self { kind: Kind::Usage, details: vec![Detail::Places(report)] }
    }
}

impl From<csv::Error> for Error {
    fn from(e: csv::Error) -> Self {
        Self::run(e.to_string())
    }
}

impl From<serde_json::Error> for Error {
    fn from(e: serde_json::Error) -> Self {
        Self::run(e.to_string())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (i, detail) in self.details.iter().enumerate() {
            let separator = if i == 0 { "" } else { "\n" };
            match detail {
                Detail::Message(message) => write!(f, "{separator}error: {message}")?,
                Detail::Places(report) => write!(f, "{separator}{report}")?,
            }
        }
        Ok(())
    }
}
