use super::*;

#[test]
fn a_target_brings_the_names_of_its_tools() {
    let firmware = Target::of("thumbv7em-none-eabihf", None).unwrap();
    assert_eq!((&*firmware.prefix, firmware.has_system()), ("arm-none-eabi-", false));
    let board = Target::of(AARCH64, Some("own-")).unwrap();
    assert_eq!((&*board.prefix, board.has_system()), ("own-", true));
    let gcc = |variable: &str| (variable.to_owned(), "own-gcc".to_owned());
    let variables = ["CC_aarch64_unknown_linux_gnu", "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER"];
    assert_eq!(board.environment(), variables.map(gcc));
    assert!(firmware.environment().is_empty() && Target::here().environment().is_empty());
    assert!(Target::here().has_system());
    assert_eq!(Target::of(&format!("{ARCH}-unknown-linux-gnu"), None), Ok(Target::here()));
}

#[test]
fn a_target_that_nothing_is_known_of_asks_for_its_tools() {
    let reason = Target::of("riscv32imac-unknown-none-elf", None).unwrap_err();
    assert!(reason.contains("riscv32imac-unknown-none-elf") && reason.contains("--binutils"), "{reason}");
}
