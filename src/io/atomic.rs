//! Atomic file writing: whole files or none. Every file of the program is written here.

use super::inputs::{check_output, final_target};
use crate::error::Error;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The temporary file is buffered in pieces of this many bytes.
const BUFFER_BYTES: usize = 1 << 16;

/// Writes the file `path` as a whole or not at all.
///
/// `write` fills a temporary file in the same directory, which is flushed to the disk and then renamed to `path`. After
/// an error or an interruption the old file, if there was one, is untouched and nothing else is left behind (on Linux
/// even when the program is killed, but for the instant between naming and renaming where there is an old file). A
/// symbolic link is followed, so the file it names is replaced, or made where there is none yet, and the link stays.
///
/// # Errors
/// A directory that is missing or cannot be written, a file marked read-only, something at `path` that is no regular
/// file, a file that this run has read ([`super::inputs`]), a full disk, and whatever `write` reports.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> Result<(), Error> {
    check_output(path)?;
    let target = replaceable(path)?;
    let directory = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    #[cfg(target_os = "linux")]
    if let Some(unnamed) = unnamed_in(directory) {
        fill(&unnamed, write).map_err(|error| explain(path, &error))?;

        // A new file is named at once, so that no kill leaves another name; only over an old one is there a name to rename.
        match link(&unnamed, &target) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            linked => return linked.map_err(|error| explain(path, &error)),
        }
        let named = builder().make_in(directory, |name| link(&unnamed, name)).map_err(|error| explain(path, &error))?;
        named.persist(&target).map_err(|error| explain(path, &error.error))?;
        return Ok(());
    }
    let temporary = builder().tempfile_in(directory).map_err(|error| explain(path, &error))?;
    fill(temporary.as_file(), write).map_err(|error| explain(path, &error))?;
    temporary.persist(&target).map_err(|error| explain(path, &error.error))?;
    Ok(())
}

/// A file without a name, which the system removes when the program ends in any way, killed or interrupted; `None`
/// where the file system has no such files.
#[cfg(target_os = "linux")]
fn unnamed_in(directory: &Path) -> Option<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let flags = rustix::fs::OFlags::TMPFILE.bits().cast_signed();
    std::fs::OpenOptions::new().write(true).custom_flags(flags).mode(0o666).open(directory).ok()
}

/// Gives a file without a name its name; it must not be taken.
#[cfg(target_os = "linux")]
fn link(unnamed: &File, name: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let own = format!("/proc/self/fd/{}", unnamed.as_raw_fd());
    Ok(linkat(CWD, own, CWD, name, AtFlags::SYMLINK_FOLLOW)?)
}

/// Writes `bytes` as the whole content of the file `path`; see [`write_atomically`].
///
/// # Errors
/// Those of [`write_atomically`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_atomically(path, |out| out.write_all(bytes))
}

/// Writes, flushes and waits until the disk has it.
fn fill(file: &File, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER_BYTES, file);
    write(&mut out)?;
    out.flush()?;
    file.sync_all()
}

/// A temporary file that gets the permissions of any new file, not the owner-only ones of a secret.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".biprism-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// The path to replace: `path` itself, or what it links to. A device, a directory and a read-only file are refused,
/// since a rename would quietly take their place.
fn replaceable(path: &Path) -> Result<PathBuf, Error> {
    if path.file_name().is_none() {
        return Err(Error::new(path.display(), "this names no file", "name a file to write"));
    }
    let found = match std::fs::metadata(path) {
        Ok(found) => found,
        // Nothing is there, or a link to nothing.
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(final_target(path)),
        Err(error) => return Err(explain(path, &error)),
    };
    if !found.is_file() {
        let kind = if found.is_dir() { "a directory" } else { "not a regular file" };
        return Err(Error::new(path.display(), format!("this is {kind}"), "name a regular file to write"));
    }
    if found.permissions().readonly() {
        return Err(Error::new(
            path.display(),
            "the file is marked read-only",
            "allow writing to it, or name another file",
        ));
    }
    std::fs::canonicalize(path).map_err(|error| explain(path, &error))
}

/// What the user is told of a failed write, with the system's reason.
fn explain(path: &Path, error: &io::Error) -> Error {
    let there = path.parent().is_some_and(|directory| directory.as_os_str().is_empty() || directory.is_dir());
    let help = match error.kind() {
        ErrorKind::NotFound if there => "no file can be made in this directory; write to another one",
        ErrorKind::NotFound | ErrorKind::NotADirectory => "create its directory first, or name another place",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "write to a directory that you may change, or ask for the right to change this one"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "make room on the disk, or write to another one; the old file, if any, is untouched"
        }
        _ => "mend the cause and run the command again; the old file, if any, is untouched",
    };
    // The name of the temporary file would say nothing.
    let told = error.to_string();
    let reason = told.split(" at path ").next().unwrap_or_default();
    Error::new(path.display(), format!("the file cannot be written: {reason}"), help)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        write_bytes(&path, b"old").unwrap();
        for kind in [ErrorKind::StorageFull, ErrorKind::Other] {
            let problem = write_atomically(&path, |out| {
                // More than the buffer, so that bytes have reached the temporary file.
                out.write_all(&vec![b'x'; 3 * BUFFER_BYTES])?;
                Err(io::Error::from(kind))
            })
            .unwrap_err();
            assert!(problem.rule.contains(&io::Error::from(kind).to_string()), "{problem}");
            assert_eq!(std::fs::read(&path).unwrap(), b"old");
            assert_eq!(names(directory.path()), ["a.txt"]);
        }
        assert!(explain(&path, &ErrorKind::StorageFull.into()).help.contains("make room"));
    }

    #[test]
    fn a_missing_directory_is_named_with_the_next_step() {
        let directory = tempfile::tempdir().unwrap();
        let problem = write_bytes(&directory.path().join("no/such/a.txt"), b"x").unwrap_err();
        assert!(problem.place.ends_with("a.txt") && problem.help.contains("create its directory"), "{problem}");
        assert!(names(directory.path()).is_empty());
    }

    #[test]
    fn what_may_not_be_replaced_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        assert!(write_bytes(directory.path(), b"x").unwrap_err().rule.contains("a directory"));
        assert!(write_bytes(Path::new(""), b"x").is_err());
        assert!(write_bytes(Path::new("/"), b"x").is_err());

        let path = directory.path().join("kept.txt");
        write_bytes(&path, b"kept").unwrap();
        let mut permissions = std::fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&path, permissions).unwrap();
        assert!(write_bytes(&path, b"x").unwrap_err().rule.contains("read-only"));
        assert_eq!(std::fs::read(&path).unwrap(), b"kept");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_a_device_is_not_replaced_and_permissions_are_the_usual_ones() {
        use std::os::unix::fs::{MetadataExt, symlink};
        let directory = tempfile::tempdir().unwrap();
        let (real, link) = (directory.path().join("real"), directory.path().join("link"));
        write_bytes(&real, b"1").unwrap();
        symlink(&real, &link).unwrap();
        write_bytes(&link, b"2").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&real).unwrap(), b"2");

        let (new, dangling) = (directory.path().join("new"), directory.path().join("dangling"));
        symlink("new", &dangling).unwrap();
        write_bytes(&dangling, b"3").unwrap();
        assert!(std::fs::symlink_metadata(&dangling).unwrap().is_symlink());
        assert_eq!(std::fs::read(&new).unwrap(), b"3");
        symlink("nowhere/x", directory.path().join("astray")).unwrap();
        assert!(write_bytes(&directory.path().join("astray"), b"4").is_err());
        symlink("loop", directory.path().join("loop")).unwrap();
        assert!(write_bytes(&directory.path().join("loop"), b"5").is_err());

        assert!(write_bytes(Path::new("/dev/null"), b"x").unwrap_err().rule.contains("not a regular file"));

        let plain = directory.path().join("plain");
        std::fs::write(&plain, b"").unwrap();
        assert_eq!(std::fs::metadata(&plain).unwrap().mode(), std::fs::metadata(&real).unwrap().mode());
    }
}
