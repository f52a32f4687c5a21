use super::*;

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn a_finished_file_has_its_content_and_no_companion() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stats.json");
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(b"{}").unwrap();
    assert!(!path.exists(), "the name must appear at finish only");
    file.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"{}");
    assert_eq!(names(folder.path()), ["stats.json"]);
}

#[test]
fn a_dropped_file_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = AtomicFile::create(&folder.path().join("image.png")).unwrap();
    file.write_all(&[0; 100_000]).unwrap();
    drop(file);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_dropped_file_keeps_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    fs::write(&path, "old").unwrap();
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(b"new").unwrap();
    drop(file);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["image.png"]);
}

#[test]
fn a_finished_file_replaces_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    fs::write(&path, "old and longer").unwrap();
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(b"new").unwrap();
    file.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_an_ordinary_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (ordinary, atomic) = (folder.path().join("a"), folder.path().join("b"));
    fs::write(&ordinary, "").unwrap();
    AtomicFile::create(&atomic).unwrap().finish().unwrap();
    let mode = |path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&atomic), mode(&ordinary));
}

#[cfg(unix)]
#[test]
fn a_symbolic_link_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real"), folder.path().join("link"));
    fs::write(&real, "old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    let mut file = AtomicFile::create(&link).unwrap();
    file.write_all(b"new").unwrap();
    file.finish().unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&real).unwrap(), b"new");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named_with_the_final_path() {
    let mut file = AtomicFile::create(Path::new("/dev/full")).unwrap();
    file.write_all(b"buffered").unwrap();
    assert_eq!(
        file.finish().unwrap_err().to_string(),
        "cannot write `/dev/full`: No space left on device"
    );
}

#[cfg(unix)]
#[test]
fn a_missing_folder_is_named_without_the_temporary_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing/image.png");
    assert_eq!(
        AtomicFile::create(&path).unwrap_err().to_string(),
        format!("cannot write `{}`: No such file or directory", path.display())
    );
}

#[test]
fn a_folder_is_no_target() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(
        AtomicFile::create(folder.path()).unwrap_err().to_string(),
        format!("cannot write `{}`: is a directory", folder.path().display())
    );
}

#[test]
fn folders_are_made_with_those_above_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a/b");
    create_dir(&path).unwrap();
    create_dir(&path).unwrap();
    assert!(path.is_dir());
    assert!(names(&path).is_empty());
}

#[test]
fn a_folder_is_claimed_by_one_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out");
    let first = OutputFolder::claim(&path).unwrap();
    let second = OutputFolder::claim(&path);
    assert_eq!(
        second.unwrap_err().to_string(),
        format!("cannot use `{}` as output folder: another run is writing into it", path.display())
    );
    assert!(OutputFolder::claim(folder.path()).is_ok(), "the folder above is another one");
    drop(first);
    OutputFolder::claim(&path).unwrap();
    assert!(names(&path).is_empty(), "nothing is left of it");
}

#[test]
fn a_file_is_no_output_folder() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out");
    fs::write(&path, "").unwrap();
    assert_eq!(
        create_dir(&path).unwrap_err().to_string(),
        format!("cannot use `{}` as output folder: it is a file, not a folder", path.display())
    );
}

#[cfg(target_os = "linux")]
#[test]
fn an_unwritable_folder_is_refused() {
    // Nobody can make a file in /proc, whatever the user's rights.
    assert_eq!(
        create_dir(Path::new("/proc")).unwrap_err().to_string(),
        "cannot use `/proc` as output folder: No such file or directory"
    );
}

/// A waveform's file, too: what the link points to is replaced, the link stays.
#[cfg(unix)]
#[test]
fn a_growing_file_follows_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real.vcd"), folder.path().join("wave.vcd"));
    fs::write(&real, "old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    let (mut file, name) = partial::create(&link).unwrap();
    file.write_all(b"new").unwrap();
    file.flush().unwrap();
    assert_eq!(fs::read(&real).unwrap(), b"old");
    drop(file);
    name.finish().unwrap();
    assert!(link.is_symlink());
    assert_eq!(fs::read(&real).unwrap(), b"new");
}
