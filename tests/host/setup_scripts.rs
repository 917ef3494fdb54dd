//! The steps of `./run` and `./test` before the build: values of `CVR_DEVICE`, and the adapter that is found, installed
//! or missing. Scripts replace `cvr devices --tsv` and the package manager.

use std::path::Path;
use std::process::{Command, Output};

const VULKAN: &str = "0\tvulkan\tcpu\tllvmpipe\tMesa\n";
const GL_IN_SOFTWARE: &str = "0\tgl\tcpu\tllvmpipe\t4.5\n";
const GL_ON_HARDWARE: &str = "0\tgl\tdiscrete\tGeForce 3090\t4.6\n";
const BOTH: &str = "0\tvulkan\tcpu\tlavapipe\tMesa\n1\tgl\tcpu\tllvmpipe\t4.5\n";

/// The test script for the functions. `$1` is a folder with the list of adapters, and the list after an installation.
const SCRIPT: &str = r#"
set -euo pipefail
. .ci/prepare.sh
folder=$1
install_packages() {
    printf '%s\n' "$*" >> "$folder/installed"
    [ -f "$folder/after" ] || return 1
    mv "$folder/after" "$folder/adapters"
}
devices() { cat "$folder/adapters"; [ -s "$folder/adapters" ]; }
check_device_switch
need_adapter devices
echo "$vulkan,$native,$gl,$hardware_gl"
"#;

struct Tried {
    output: Output,
    installed: String,
}

impl Tried {
    fn said(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    fn found(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).trim().to_owned()
    }
}

/// `after` is the list after packages are installed. `None` if none can be installed.
fn try_out(switch: Option<&str>, adapters: &str, after: Option<&str>) -> Tried {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("adapters"), adapters).unwrap();
    if let Some(after) = after {
        std::fs::write(folder.path().join("after"), after).unwrap();
    }
    let mut bash = Command::new("bash");
    bash.args(["-c", SCRIPT, "bash"]).arg(folder.path()).current_dir(root()).env_remove("CVR_DEVICE");
    bash.envs(switch.map(|switch| ("CVR_DEVICE", switch)));
    let output = bash.output().unwrap();
    let installed = std::fs::read_to_string(folder.path().join("installed")).unwrap_or_default();
    Tried { output, installed }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The adapter that is found at the end, the packages installed for it, and a part of the message.
fn assert_found(tried: &Tried, found: &str, installed: &str, said: &str) {
    let all = tried.said();
    assert_eq!(tried.output.status.code(), Some(0), "{all}");
    assert_eq!((tried.found().as_str(), tried.installed.trim()), (found, installed), "{all}");
    assert!(if said.is_empty() { all.is_empty() } else { all.contains(said) }, "{all}");
}

#[test]
fn what_is_good_enough_is_left_as_it_is() {
    for switch in [None, Some("auto"), Some("required")] {
        assert_found(&try_out(switch, VULKAN, None), "llvmpipe,llvmpipe,,", "", "");
        assert_found(&try_out(switch, BOTH, None), "lavapipe,lavapipe,llvmpipe,", "", "");
        assert_found(&try_out(switch, GL_ON_HARDWARE, None), ",,GeForce 3090,GeForce 3090", "", "");
    }
    assert_found(&try_out(Some("none"), "", None), ",,,", "", "");
    assert_found(&try_out(Some("gl"), BOTH, None), "lavapipe,lavapipe,llvmpipe,", "", "");
}

#[test]
fn vulkan_is_installed_where_there_is_nothing_or_gl_in_software() {
    let packages = "mesa-vulkan-drivers libvulkan1";
    for switch in [None, Some("auto"), Some("required"), Some("vulkan")] {
        for adapters in ["", GL_IN_SOFTWARE] {
            let tried = try_out(switch, adapters, Some(BOTH));
            assert_found(&tried, "lavapipe,lavapipe,llvmpipe,", packages, "");
        }
    }
    let tried = try_out(Some("vulkan"), GL_ON_HARDWARE, Some(BOTH));
    assert_found(&tried, "lavapipe,lavapipe,llvmpipe,", packages, "");
    let tried = try_out(Some("gl"), VULKAN, Some(BOTH));
    assert_found(&tried, "lavapipe,lavapipe,llvmpipe,", "libegl1 libgl1-mesa-dri", "");
}

#[test]
fn where_nothing_can_be_installed_what_is_there_draws_and_it_is_said() {
    let packages = "mesa-vulkan-drivers libvulkan1";
    let tried = try_out(None, GL_IN_SOFTWARE, None);
    assert_found(&tried, ",,llvmpipe,", packages, "Vulkan cannot be installed: llvmpipe draws through GL.");
    let tried = try_out(None, "", None);
    assert_found(&tried, ",,,", packages, "none can be installed: the CPU mirror draws instead.");
    // Installed, but the new driver does not start.
    let tried = try_out(None, GL_IN_SOFTWARE, Some(GL_IN_SOFTWARE));
    assert_found(&tried, ",,llvmpipe,", packages, "llvmpipe draws through GL.");
}

#[test]
fn what_is_demanded_and_missing_ends_with_a_sentence() {
    for (switch, adapters) in [
        ("required", ""),
        ("vulkan", ""),
        ("vulkan", GL_IN_SOFTWARE),
        ("vulkan", GL_ON_HARDWARE),
        ("gl", ""),
        ("gl", VULKAN),
    ] {
        let tried = try_out(Some(switch), adapters, None);
        let said = tried.said();
        assert_eq!(tried.output.status.code(), Some(2), "{switch}: {said}");
        assert!(said.starts_with(&format!("CVR_DEVICE={switch}: no ")), "{said}");
        assert!(said.trim_end().ends_with("found, and none can be installed."), "{said}");
    }
}

/// The scripts themselves, which end before they build.
#[test]
fn an_unknown_word_is_an_error_before_anything_is_built() {
    for script in ["run", "test"] {
        for word in ["yes", "Vulkan", "opengl"] {
            let output = Command::new(root().join(script)).env("CVR_DEVICE", word).output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{script}: {said}");
            assert_eq!(
                said,
                format!("CVR_DEVICE={word}: it must be required, vulkan, gl, auto or none.\n"),
                "{script}"
            );
        }
    }
}

/// A test binary in a folder of this name, run as `./test` does: exit code, output, and times. One with `knows_times`
/// answers the question for times.
fn run_timed(folder_name: &str, knows_times: bool) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let (deps, times) = (folder.path().join(folder_name), folder.path().join("times"));
    std::fs::create_dir(&deps).unwrap();
    let (binary, listed) = (deps.join("fake-test-0123"), i32::from(!knows_times));
    let text = format!(
        "#!/bin/sh\ncase \" $* \" in *' --list '*) exit {listed} ;; esac\necho \"given: $*\"\n\
         echo 'test a::b ... ok <1.250s>'\necho 'test c - should panic ... FAILED <0.500s>'\nexit 101\n"
    );
    // Another process writes the file: a program cannot be run while any forked process holds it open.
    let mut write = Command::new("sh");
    write.args(["-c", "printf %s \"$1\" > \"$2\" && chmod +x \"$2\"", "sh", &text]).arg(&binary);
    assert!(write.status().unwrap().success());
    let mut script = Command::new(root().join(".ci/timed.sh"));
    let output = script.arg(&binary).args(["--quiet", "some_name"]).env("CVR_TEST_TIMES", &times).output();
    let output = output.unwrap();
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), printed, std::fs::read_to_string(&times).unwrap_or_default())
}

#[test]
fn tests_are_timed_and_nothing_else_about_them_changes() {
    let (code, printed, times) = run_timed("deps", true);
    assert_eq!(code, Some(101));
    assert_eq!(
        printed,
        "given: -Zunstable-options --report-time some_name\ntest c - should panic ... FAILED <0.500s>\n"
    );
    assert_eq!(times, "1.250\tfake-test\ta::b\n0.500\tfake-test\tc\n");
}

#[test]
fn what_cannot_be_timed_runs_as_it_is() {
    for (folder, knows_times) in [("deps", false), ("elsewhere", true)] {
        let (code, printed, times) = run_timed(folder, knows_times);
        assert_eq!((code, times.as_str()), (Some(101), ""), "{folder}");
        assert!(printed.starts_with("given: --quiet some_name\ntest a::b ... ok"), "{folder}: {printed}");
    }
}

/// CPU time is that of the programs that the script has run. A shell that is ended after two seconds of CPU time took
/// two.
#[test]
fn cpu_time_is_counted() {
    let script = r#"
. .ci/cpu.sh
count_cpu
before=$cpu_seconds
sh -c 'ulimit -t 2; while :; do :; done' || true
count_cpu
echo $((cpu_seconds - before))
"#;
    let output = Command::new("bash").args(["-c", script]).current_dir(root()).output().unwrap();
    let counted = String::from_utf8_lossy(&output.stdout).trim().parse::<u32>();
    assert!(matches!(counted, Ok(1..=3)), "{counted:?}: {}", String::from_utf8_lossy(&output.stderr));
}
