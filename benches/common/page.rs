//! Tables in the pages of `docs` that benchmarks write anew.

use std::path::Path;

/// The page of this name, with other rows in the tables between these marks; their two heading lines stay.
pub fn rewrite(name: &str, tables: &[(&str, &[String])]) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name);
    let page = std::fs::read_to_string(&file).expect("the page can be read");
    let page = tables.iter().fold(page, |page, (mark, rows)| with_rows(&page, mark, rows));
    std::fs::write(file, page).expect("the page can be written");
}

fn with_rows(page: &str, mark: &str, rows: &[String]) -> String {
    let (begin, end) = (format!("<!-- {mark} -->\n"), format!("<!-- end of {mark} -->\n"));
    let (before, rest) = page.split_once(&begin).expect("the page has the table's mark");
    let (table, after) = rest.split_once(&end).expect("the page has the mark of the table's end");
    let heading: Vec<&str> = table.lines().take(2).collect();
    format!("{before}{begin}{}\n{}\n{end}{after}", heading.join("\n"), rows.join("\n"))
}
