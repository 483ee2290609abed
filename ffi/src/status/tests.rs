use super::red_status;

#[test]
fn every_status_is_listed_once_and_its_text_is_what_the_header_says() {
    let source = include_str!("../status.rs");
    let body = source.split("pub enum red_status {").nth(1).and_then(|rest| rest.split("\n}").next());
    let lines: Vec<&str> = body.expect("the enumeration").trim().lines().map(str::trim).collect();
    assert_eq!(lines.len(), 2 * red_status::ALL.len());
    let mut numbers = Vec::new();
    for (pair, status) in lines.chunks(2).zip(red_status::ALL) {
        let [said, variant] = pair else { panic!("{pair:?}") };
        assert_eq!(*variant, format!("{status:?} = {},", *status as i32));
        let text = status.text().to_str().expect("ASCII");
        let said = said.trim_start_matches("/// ").trim_end_matches('.');
        assert_eq!(said.to_lowercase(), text.to_lowercase());
        numbers.push(*status as i32);
    }
    assert!(numbers.is_sorted_by(|a, b| a < b), "numbers grow, so none is there twice");
}
