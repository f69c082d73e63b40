//! The step `homes`: two homes behind routers in network namespaces of this machine, with `host-sim` as it is built for tests.

use crate::run::{self, Failure, command};
use crate::{page, setup, test};

/// Why it cannot be tried here, if so; installs `ip` and `nft` where that is all that is missing.
pub(crate) fn obstacle() -> Option<String> {
    if !cfg!(target_os = "linux") {
        return Some("network namespaces are Linux's".to_owned());
    }
    if run::output(&mut command("id", &["-u"])).is_ok_and(|id| id.trim() != "0") {
        return Some("network namespaces need root".to_owned());
    }
    // `ip` has no `--version`, and answers it with its help.
    let ip = if run::succeeds(&mut command("ip", &["-V"])) { None } else { setup::program("ip", "iproute2") };
    ip.or_else(|| setup::program("nft", "nftables")).or_else(|| {
        let name = "haptic-homes-probe";
        let made = run::succeeds(&mut command("ip", &["netns", "add", name]));
        let rules = "table ip probe { chain c { type nat hook postrouting priority 100; masquerade; }; }";
        let works = made && run::succeeds(&mut command("ip", &["netns", "exec", name, "nft", rules]));
        let _ = run::succeeds(&mut command("ip", &["netns", "del", name]));
        (!works).then(|| "this machine lets nobody make network namespaces with routers in them".to_owned())
    })
}

/// Runs the tests behind routers, one after the other; that of two people takes as long as `HAPTIC_HOMES_S` says, s.
pub(crate) fn homes() -> Result<(), Failure> {
    page::browser()?;
    // As all tests are built, so that nothing is built twice.
    let chosen = ["--test", "homes", "--", "routers", "pages", "--ignored"];
    run::run(test::debug_tests().args(chosen).args(["--test-threads", "1"]))
}
