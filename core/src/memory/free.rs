//! Free memory of the machine, or of this process's control group.

use std::path::Path;

use super::{Bound, Source};

/// Free bytes: the memory that Linux reports as available, or less if a control group (version 1 or 2, this group or a
/// parent) allows less. `None` on systems that do not report it.
#[must_use]
pub fn free() -> Option<Bound> {
    free_under(Path::new("/"))
}

/// As [`free`], with another root folder.
fn free_under(root: &Path) -> Option<Bound> {
    let machine = available(root).map(|bytes| Bound { bytes, source: Source::Machine });
    let group = groups(root).into_iter().min().map(|bytes| Bound { bytes, source: Source::ControlGroup });
    machine.into_iter().chain(group).min_by_key(|bound| bound.bytes)
}

/// `MemAvailable` of `/proc/meminfo`.
fn available(root: &Path) -> Option<u64> {
    let text = std::fs::read_to_string(root.join("proc/meminfo")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kib.checked_mul(1024)
}

/// File names of one version of control groups.
struct Files {
    /// Where the hierarchy is mounted.
    mount: &'static str,
    limit: &'static str,
    usage: &'static str,
    /// Key in `memory.stat`: inactive file pages. The system reclaims them before it refuses memory.
    inactive: &'static str,
}

const VERSION_1: Files = Files {
    mount: "sys/fs/cgroup/memory",
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    inactive: "total_inactive_file",
};
const VERSION_2: Files =
    Files { mount: "sys/fs/cgroup", limit: "memory.max", usage: "memory.current", inactive: "inactive_file" };
/// Mount point of version 2 if both versions are mounted.
const VERSION_2_BESIDE: Files = Files { mount: "sys/fs/cgroup/unified", ..VERSION_2 };

/// Free bytes of each group of this process, and of each parent group.
fn groups(root: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(root.join("proc/self/cgroup")).unwrap_or_default();
    let mut free = Vec::new();
    for line in text.lines() {
        // `number:controllers:path`
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let versions: &[Files] = match controllers {
            "" => &[VERSION_2, VERSION_2_BESIDE],
            list if list.split(',').any(|name| name == "memory") => &[VERSION_1],
            _ => &[],
        };
        for files in versions {
            let mount = root.join(files.mount);
            // Inside a container the path may be the host's, while only the mount itself exists.
            let group = Path::new(path.trim_start_matches('/'));
            free.extend(group.ancestors().filter_map(|group| free_of(&mount.join(group), files)));
        }
    }
    free
}

/// Free bytes of one group. `None` if it has no limit or does not exist.
fn free_of(group: &Path, files: &Files) -> Option<u64> {
    let read = |name: &str| std::fs::read_to_string(group.join(name)).ok();
    let number = |name: &str| read(name)?.trim().parse::<u64>().ok();
    // `max` is not a number.
    let (limit, usage) = (number(files.limit)?, number(files.usage)?);
    let inactive = read("memory.stat").and_then(|stat| {
        stat.lines().find_map(|line| line.strip_prefix(files.inactive)?.trim().parse::<u64>().ok())
    });
    Some(limit.saturating_sub(usage.saturating_sub(inactive.unwrap_or(0))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A root with these files.
    fn root(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = root.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        root
    }

    fn free(files: &[(&str, &str)]) -> Option<(u64, Source)> {
        free_under(root(files).path()).map(|bound| (bound.bytes, bound.source))
    }

    const MEMINFO: (&str, &str) =
        ("proc/meminfo", "MemTotal:  9000 kB\nMemAvailable:   8000 kB\nBuffers: 1 kB\n");
    const MACHINE: Option<(u64, Source)> = Some((8000 * 1024, Source::Machine));

    #[test]
    fn the_machine_tells_what_is_available() {
        assert_eq!(free(&[MEMINFO]), MACHINE);
        assert_eq!(free(&[]), None);
        assert_eq!(free(&[("proc/meminfo", "MemAvailable: many kB\n")]), None);
    }

    #[test]
    fn the_tightest_group_above_a_process_counts() {
        let own = ("proc/self/cgroup", "0::/user/job\n");
        let limit = |path: &'static str, limit: &'static str| (path, limit);
        let tree = |own_max, parent_max| {
            free(&[
                MEMINFO,
                own,
                limit("sys/fs/cgroup/user/job/memory.max", own_max),
                ("sys/fs/cgroup/user/job/memory.current", "300000\n"),
                ("sys/fs/cgroup/user/job/memory.stat", "anon 5\ninactive_file 100000\nactive_file 7\n"),
                limit("sys/fs/cgroup/user/memory.max", parent_max),
                ("sys/fs/cgroup/user/memory.current", "400000\n"),
            ])
        };
        assert_eq!(tree("max\n", "max\n"), MACHINE);
        // Inactive file pages count as free.
        assert_eq!(tree("1000000\n", "max\n"), Some((800_000, Source::ControlGroup)));
        assert_eq!(tree("1000000\n", "500000\n"), Some((100_000, Source::ControlGroup)));
        assert_eq!(
            tree("200000\n", "max\n"),
            Some((0, Source::ControlGroup)),
            "a group over its limit has none"
        );
        assert_eq!(
            tree("99999999999\n", "max\n"),
            MACHINE,
            "a group that may take more than the machine has"
        );
    }

    #[test]
    fn a_container_sees_its_own_group_at_the_mount() {
        let files = [
            MEMINFO,
            ("proc/self/cgroup", "0::/docker/abc\n"),
            ("sys/fs/cgroup/memory.max", "600000"),
            ("sys/fs/cgroup/memory.current", "100000"),
        ];
        assert_eq!(free(&files), Some((500_000, Source::ControlGroup)));
    }

    #[test]
    fn the_first_version_has_a_hierarchy_for_memory() {
        let files = |limit| {
            [
                MEMINFO,
                ("proc/self/cgroup", "9:cpu,cpuacct:/other\n4:memory:/job\n0::/\n"),
                ("sys/fs/cgroup/memory/job/memory.limit_in_bytes", limit),
                ("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "500000\n"),
                ("sys/fs/cgroup/memory/job/memory.stat", "inactive_file 1\ntotal_inactive_file 200000\n"),
                ("sys/fs/cgroup/memory/other/memory.limit_in_bytes", "1\n"),
            ]
        };
        assert_eq!(free(&files("1000000\n")), Some((700_000, Source::ControlGroup)));
        // The kernel writes this if there is no limit.
        assert_eq!(free(&files("9223372036854771712\n")), MACHINE);
    }
}
