use super::*;

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_whole(path, |f| f.write_all(bytes))
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    write(&path, b"old").unwrap();
    let failed = write_whole(&path, |f| {
        f.write_all(b"half")?;
        Err(io::Error::other("no more"))
    });
    assert!(failed.is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(write(folder.path(), b"x").unwrap_err().to_string(), "is a folder");
}

#[test]
fn temporary_names_are_known_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let made = temporary_folder(folder.path()).unwrap();
    assert!(is_temporary(&made.path().file_name().unwrap().to_string_lossy()));
    let names = [
        ".tmpab12cd",
        ".cvr-ab12cd",
        ".cvr-ab12c.part",
        ".cvr-ab/2cd.part",
        "a.cvr-ab12cd.part",
        ".cvr-.part",
    ];
    for name in names {
        assert!(!is_temporary(name), "{name}");
    }
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{FileTypeExt as _, symlink};
    use std::process::Command;

    use super::*;

    #[test]
    fn a_link_stays_and_what_it_names_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("far")).unwrap();
        write(&at("far/file"), b"old").unwrap();
        // A second name of the old file shows whether it was replaced or overwritten.
        std::fs::hard_link(at("far/file"), at("old")).unwrap();
        symlink("far/file", at("link")).unwrap();
        symlink("link", at("link to link")).unwrap();
        for (link, bytes) in [("link", b"one"), ("link to link", b"two")] {
            write(&at(link), bytes).unwrap();
            assert!(std::fs::symlink_metadata(at(link)).unwrap().is_symlink());
            assert_eq!(
                (std::fs::read(at("far/file")).unwrap(), std::fs::read(at("old")).unwrap()),
                (bytes.to_vec(), b"old".to_vec())
            );
        }
        assert_eq!(std::fs::read_dir(at("far")).unwrap().count(), 1);
        // The target of a link need not exist. A failed write does not create it.
        symlink("far/new", at("dangling")).unwrap();
        assert!(write_whole(&at("dangling"), |_| Err(io::Error::other("no"))).is_err());
        assert!(!at("far/new").exists());
        write(&at("dangling"), b"new").unwrap();
        assert_eq!(std::fs::read(at("far/new")).unwrap(), b"new");
        assert!(std::fs::symlink_metadata(at("dangling")).unwrap().is_symlink());
        symlink("round", at("round")).unwrap();
        assert!(write(&at("round"), b"x").is_err());
    }

    #[test]
    fn a_device_node_stays_one() {
        let before = std::fs::metadata("/dev/null").unwrap().file_type();
        write(Path::new("/dev/null"), &[7; 100_000]).unwrap();
        assert!(
            before.is_char_device() && std::fs::symlink_metadata("/dev/null").unwrap().file_type() == before
        );
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        symlink("/dev/null", &link).unwrap();
        write(&link, b"x").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    /// The twin of a full disk: buffered bytes must not get lost without an error, not even one.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_an_error() {
        for length in [1, 100_000] {
            let full = write(Path::new("/dev/full"), &vec![7; length]).unwrap_err();
            assert_eq!(full.kind(), io::ErrorKind::StorageFull);
        }
    }

    #[test]
    fn a_fifo_is_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let fifo = folder.path().join("fifo");
        assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        let reader = std::thread::spawn({
            let fifo = fifo.clone();
            move || std::fs::read(fifo).unwrap()
        });
        write(&fifo, &[7; 100_000]).unwrap();
        assert_eq!(reader.join().unwrap(), vec![7; 100_000]);
        assert!(std::fs::symlink_metadata(&fifo).unwrap().file_type().is_fifo());
    }
}
