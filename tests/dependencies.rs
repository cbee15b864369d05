//! Does the table of dependencies say what the manifests say, and is unsafe code where it is said to be?

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Names in `[workspace.dependencies]` that do not come from this repository.
fn declared() -> BTreeSet<String> {
    let manifest = read(&root().join("Cargo.toml"));
    let (_, rest) = manifest.split_once("[workspace.dependencies]").unwrap();
    let (section, _) = rest.split_once("\n[").unwrap();
    let names = section.lines().filter(|line| !line.contains("path = ")).filter_map(|line| {
        let (name, _) = line.split_once(" = ")?;
        name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)).then(|| name.to_owned())
    });
    names.collect()
}

#[test]
fn every_dependency_has_its_reason() {
    let table = read(&root().join("docs/dependencies.md"));
    let rows: Vec<Vec<&str>> = table
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| crate") && !line.starts_with("| ---"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.iter().all(|row| row.len() == 4 && row.iter().all(|cell| !cell.is_empty())), "{rows:?}");
    let told: BTreeSet<String> = rows.iter().map(|row| row[0].to_owned()).collect();
    assert_eq!(told, declared());
}

fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() && name != "target" && name != "out" && !name.to_string_lossy().starts_with('.') {
            sources(&path, all);
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
}

#[test]
fn unsafe_code_is_where_it_is_said_to_be() {
    let mut all = Vec::new();
    sources(root(), &mut all);
    // In two halves, so that this file is not found.
    let allowed = ["allow(unsafe", "_code)"].concat();
    let found: Vec<_> = all.iter().filter(|path| read(path).contains(&allowed)).collect();
    assert_eq!(found, [&root().join("denoise/src/oidn/library.rs")]);
}
