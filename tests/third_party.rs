//! The crates of others in the command, in units and in wheels: their lists are current, and so is the README.
//!
//! `QRM_REFRESH=1 cargo test --release --test integration third_party` writes the files anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Systems on which units are made.
const SYSTEMS: [&str; 3] = ["x86_64-unknown-linux-gnu", "x86_64-pc-windows-msvc", "aarch64-apple-darwin"];

/// Licences, and a crate and its file that has their text.
const TEXTS: [(&str, &str, &str); 8] = [
    ("MIT", "cfg-if", "LICENSE-MIT"),
    ("Apache-2.0", "nalgebra", "LICENSE"),
    ("BSD-2-Clause", "arrayref", "LICENSE"),
    ("BSD-3-Clause", "tiny-skia", "LICENSE"),
    ("CC0-1.0", "notify", "LICENSE-CC0"),
    ("ISC", "inotify", "LICENSE"),
    ("Zlib", "zlib-rs", "LICENSE"),
    ("Unicode-3.0", "unicode-ident", "LICENSE-UNICODE"),
];

const README: &str = include_str!("../README.md");

/// A product that contains third-party code.
struct Product {
    /// The package that is linked.
    package: &'static str,
    /// The folder of its workspace.
    folder: &'static str,
    /// The lock file of the product.
    lock: &'static str,
    /// The list of its crates.
    file: &'static str,
    /// The name of the product in words.
    name: &'static str,
}

const COMMAND: Product = Product {
    package: "qrm",
    folder: ".",
    lock: include_str!("../Cargo.lock"),
    file: "crates/cli/THIRD-PARTY.txt",
    name: "the command `qrm` and in the units that it exports",
};
const WHEEL: Product = Product {
    package: "qrm-python",
    folder: "python",
    lock: include_str!("../python/Cargo.lock"),
    file: "python/THIRD-PARTY.txt",
    name: "the Python package `qrm`",
};

impl Product {
    fn path(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join(self.file)
    }

    fn lock(&self) -> String {
        self.lock.replace('\r', "")
    }

    /// The line that ties the file to the lock file.
    fn tie(&self) -> String {
        format!("Made from a Cargo.lock with the digest {:016x}.", qrm_core::digest(self.lock().bytes()))
    }
}

fn cargo(product: &Product, arguments: &[&str]) -> String {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(arguments)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(product.folder))
        .output();
    let output = output.expect("cargo starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// Name and version of each crate of others that is linked on any system.
fn linked(product: &Product) -> BTreeSet<(String, String)> {
    let mut linked = BTreeSet::new();
    for system in SYSTEMS {
        let tree = [
            "tree",
            "--locked",
            "--package",
            product.package,
            "--no-default-features",
            "--edges=normal,no-proc-macro",
            "--prefix=none",
            "--target",
            system,
        ];
        for line in cargo(product, &tree).lines() {
            let mut words = line.split(' ');
            if let (Some(name), Some(version)) = (words.next(), words.next())
                && !name.starts_with("qrm")
            {
                linked.insert((name.to_owned(), version.trim_start_matches('v').to_owned()));
            }
        }
    }
    linked
}

/// The files of a crate that name licences, by name.
fn licence_files(folder: &Path) -> BTreeMap<String, String> {
    let entries = std::fs::read_dir(folder).expect("a crate's folder").flatten();
    let files = entries.filter_map(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_one = ["LICEN", "COPY", "NOTICE"].iter().any(|start| name.to_uppercase().starts_with(start));
        Some((name, std::fs::read_to_string(entry.path()).ok()?)).filter(|_| is_one)
    });
    files.collect()
}

/// Lines in which a crate's files say whose it is.
fn copyrights(files: &BTreeMap<String, String>) -> BTreeSet<String> {
    let lines = files.values().flat_map(|text| text.lines()).map(str::trim);
    let is_one = |line: &&str| {
        let line = line.to_lowercase();
        let begins = |starts: &[&str]| starts.iter().any(|start| line.starts_with(start));
        let has_year = line.split(|c: char| !c.is_ascii_digit()).any(|digits| digits.len() == 4);
        begins(&["copyright (c) ", "copyright \u{a9} "]) || begins(&["copyright ", "(c) "]) && has_year
    };
    lines.filter(is_one).map(str::to_owned).collect()
}

/// The text of a licence without whose it is, and without spaces at the ends of lines.
fn bare(text: &str) -> String {
    let is_own = |line: &&str| {
        let line = line.trim().to_lowercase();
        !(line.starts_with("copyright (c)") || line.starts_with("(c) ") || line == "all rights reserved.")
    };
    text.lines().filter(is_own).map(str::trim_end).collect::<Vec<_>>().join("\n").trim_matches('\n').to_owned()
}

fn made(product: &Product) -> String {
    let metadata: Value =
        serde_json::from_str(&cargo(product, &["metadata", "--locked", "--format-version=1"])).expect("metadata");
    let packages = metadata["packages"].as_array().expect("packages");
    let text = |package: &Value, key: &str| package[key].as_str().unwrap_or_default().to_owned();
    let folder = |package: &Value| Path::new(&text(package, "manifest_path")).with_file_name("");
    let linked = linked(product);
    let mut made = format!(
        "Code of others in {}\n\n\
         {} crates, for Linux, Windows or macOS; and the Rust standard library, MIT OR Apache-2.0,\n\
         Copyright (c) The Rust Project Contributors. The texts of the licences follow the list.\n\n\
         qrm itself is licensed under MIT OR Apache-2.0. The scene of a unit has the licence that its author gives \
         it.\n\n\
         {}\n\n",
        product.name,
        linked.len(),
        product.tie(),
    );
    let mut notices = String::new();
    for (name, version) in &linked {
        let package = packages.iter().find(|package| package["name"] == **name && package["version"] == **version);
        let package = package.expect("what is linked has metadata");
        let licence = text(package, "license");
        let is_known = |id: &str| TEXTS.iter().any(|(known, ..)| *known == id);
        assert!(licence.split([' ', '/', '(', ')']).any(is_known), "{name}: the licence {licence} has no text here");
        writeln!(made, "{name} {version}: {licence}").expect("a string");
        let repository = text(package, "repository");
        writeln!(made, "    {}", repository.trim_end_matches('/')).expect("a string");
        let files = licence_files(&folder(package));
        let mut whose = copyrights(&files);
        if whose.is_empty() {
            let authors = package["authors"].as_array().expect("a list").iter().filter_map(Value::as_str);
            whose.extend(authors.map(|author| format!("by {author}")));
        }
        whose.iter().for_each(|whose| writeln!(made, "    {whose}").expect("a string"));
        for (_, notice) in files.iter().filter(|(file, _)| file.starts_with("NOTICE")) {
            write!(notices, "\n==== notice of {name} ====\n\n{}\n", notice.trim_end()).expect("a string");
        }
    }
    made += &notices;
    for (licence, of, file) in TEXTS {
        let (_, version) = linked.iter().find(|(name, _)| name == of).expect("a crate that is linked");
        let package = packages.iter().find(|package| package["name"] == of && package["version"] == **version);
        let text = &licence_files(&folder(package.expect("metadata")))[file];
        write!(made, "\n==== {licence} ====\n\n{}\n", bare(text)).expect("a string");
    }
    made
}

/// The number of crates in a list, which is current.
fn listed(product: &Product) -> usize {
    if std::env::var_os("QRM_REFRESH").is_some() {
        std::fs::write(product.path(), made(product)).expect("the file can be written");
    }
    let text = std::fs::read_to_string(product.path()).expect("the file");
    let help = "QRM_REFRESH=1 cargo test --release --test integration third_party";
    assert!(text.contains(&product.tie()), "Cargo.lock has changed: {help} lists its crates anew");
    let (list, texts) = text.split_at(text.find("\n==== ").expect("texts after the list"));
    let entries: Vec<(&str, &str)> = list
        .lines()
        .filter_map(|line| line.split_once(": ")?.0.split_once(' '))
        .filter(|(name, version)| !name.is_empty() && version.starts_with(|c: char| c.is_ascii_digit()))
        .collect();
    assert!(entries.len() > 50, "{entries:?}");
    for (name, version) in &entries {
        let entry = format!("name = \"{name}\"\nversion = \"{version}\"\n");
        assert!(product.lock().contains(&entry), "{name} {version} is not in Cargo.lock");
    }
    for (licence, ..) in TEXTS {
        assert!(texts.contains(&format!("\n==== {licence} ====\n")), "{licence}");
    }
    let count = entries.len();
    assert!(list.contains(&format!("\n{count} crates, ")), "the file counts other than {count} crates");
    count
}

#[test]
fn the_lists_are_those_of_the_lock_files() {
    let count = listed(&COMMAND);
    let flowing = README.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flowing.contains(&format!(" {count} crates of others")), "the README counts other than {count} crates");
    listed(&WHEEL);
}
