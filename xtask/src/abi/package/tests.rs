use super::*;

#[test]
fn no_name_is_left_without_its_value() {
    let besides = ["-lm".to_owned(), "-ldl".to_owned()];
    let [(_, config), (_, version)] = cmake(&besides);
    let [(_, core), (name, all)] = Layer::ALL.map(|layer| pkg_config(layer, &besides));
    for text in [&config, &version, &core, &all] {
        assert!(!text.contains('@'), "{text}");
    }
    assert!(config.contains("INTERFACE_LINK_LIBRARIES \"m;dl\""), "{config}");
    assert!(name == "red.pc" && all.contains("Libs.private: -lm -ldl\n"), "{all}");
}

#[test]
fn what_fits_together_is_told_by_the_minor_number_only_below_1_0() {
    assert_eq!(env!("CARGO_PKG_VERSION_MAJOR"), "0", "redConfigVersion.cmake.in holds minor numbers apart");
}
