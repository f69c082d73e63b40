//! The step `homes`: two homes behind routers in network namespaces of this machine, with `cohold` as it is built for tests; and the recipes of
//! docs/guides/own-network.md, with the programs that they name.

use crate::run::{self, Failure, command};
use crate::{page, setup, test};

/// Why it cannot be tried here, if so; installs the programs that it takes where that is all that is missing.
pub(crate) fn obstacle() -> Option<String> {
    if !cfg!(target_os = "linux") {
        return Some("network namespaces are Linux's".to_owned());
    }
    if run::output(&mut command("id", &["-u"])).is_ok_and(|id| id.trim() != "0") {
        return Some("network namespaces need root".to_owned());
    }
    let programs = [("ip -V", "iproute2"), ("nft", "nftables"), ("irtt version", "irtt"), ("ping -V", "iputils-ping")];
    programs.iter().find_map(|(asked, package)| setup::program(asked, package)).or_else(|| {
        let name = "cohold-homes-probe";
        let made = run::succeeds(&mut command("ip", &["netns", "add", name]));
        let rules = "table ip probe { chain c { type nat hook postrouting priority 100; masquerade; }; }";
        let works = made && run::succeeds(&mut command("ip", &["netns", "exec", name, "nft", rules]));
        let _ = run::succeeds(&mut command("ip", &["netns", "del", name]));
        (!works).then(|| "this machine lets nobody make network namespaces with routers in them".to_owned())
    })
}

/// Runs the tests behind routers, one after the other; that of two people takes as long as `COHOLD_HOMES_S` says, s.
pub(crate) fn homes() -> Result<(), Failure> {
    page::browser()?;
    // As all tests are built, so that nothing is built twice.
    let chosen = "--test homes -- routers pages recipes --ignored --test-threads 1";
    run::run(test::debug_tests().args(chosen.split(' ')))
}
