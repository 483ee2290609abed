//! What programs read of a page.

use serde_json::Value;

/// The object in the script element `redrt-data`.
pub(crate) fn data(page: &str) -> Value {
    let (_, after) = page.split_once("id=\"redrt-data\">").expect("the page has data");
    let (json, _) = after.split_once("</script>").expect("the element ends");
    serde_json::from_str(json).unwrap_or_else(|e| panic!("{e}: {json}"))
}
