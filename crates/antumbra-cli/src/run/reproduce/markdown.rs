//! Numbers and tables as Markdown.

/// A table. Columns of numbers to the right, all others to the left.
pub(super) fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut text = line(&head.iter().map(|h| (*h).to_owned()).collect::<Vec<_>>());
    let number = |cell: &str| {
        let unit = |c: char| c.is_ascii_digit() || ",. kM".contains(c);
        cell.chars().all(unit)
    };
    let rule = (0..head.len()).map(|i| {
        let numbers = rows.iter().filter_map(|r| r.get(i)).all(|cell| number(cell));
        if numbers { "---:" } else { "---" }.to_owned()
    });
    text += &line(&rule.collect::<Vec<_>>());
    for row in rows {
        text += &line(row);
    }
    text
}

/// A count with three digits or more: `1,234`, `56.7 k`, `8.90 M`.
pub(super) fn short(n: u64) -> String {
    let v = n as f64;
    match n {
        0..10_000 => grouped(n),
        10_000..1_000_000 => format!("{:.1} k", v / 1e3),
        1_000_000..100_000_000 => format!("{:.2} M", v / 1e6),
        _ => format!("{:.0} M", v / 1e6),
    }
}

/// All digits, in groups of three.
pub(super) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Mebibytes, which the papers call MB.
pub(super) fn mib(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 / f64::from(1u32 << 20))
}

/// How many times `a` is `b`.
pub(super) fn ratio(a: u64, b: u64) -> f64 {
    a as f64 / b.max(1) as f64
}

/// A ratio with two digits or more.
pub(super) fn times(r: f64) -> String {
    if r < 10.0 { format!("{r:.2}") } else { format!("{r:.0}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_right() {
        assert_eq!(
            [0, 999, 1234, 56_700, 8_900_000, 2_199_220_000].map(short),
            ["0", "999", "1,234", "56.7 k", "8.90 M", "2199 M"]
        );
        assert_eq!([7, 1_000, 279_163].map(grouped), ["7", "1,000", "279,163"]);
        assert_eq!(mib(35_732_992), "34.08");
        assert_eq!((times(ratio(10, 4)), times(ratio(1000, 3))), ("2.50".to_owned(), "333".to_owned()));
    }

    #[test]
    fn a_table_has_a_rule_under_its_head() {
        let text = table(&["a", "b"], &[vec!["x".to_owned(), "1.5 k".to_owned()]]);
        assert_eq!(text, "| a | b |\n| --- | ---: |\n| x | 1.5 k |\n");
    }
}
