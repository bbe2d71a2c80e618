//! Parses the orders of the page: one JSON object each.

use contract::{Incarnation, Order, Pace};
use serde::Deserialize;

/// An order as the page sends it.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "order", rename_all = "snake_case", deny_unknown_fields)]
enum Wanted {
    /// Hold back the next landing.
    Pause {},
    /// Allow landings again.
    Resume {},
    /// Allow one landing.
    Step {},
    /// Land at another pace.
    Pace {
        /// `max`, `real`, a multiple of real time as `3600x`, or landings per second.
        pace: String,
    },
    /// Hand over to another planner.
    HandOver {
        /// Incarnation of that planner, sixteen hexadecimal digits.
        life: String,
    },
}

/// The order in `body`, which is at most [`super::gate::BODY_BYTES_MAX`] bytes long.
///
/// # Errors
/// What was needed and what was got, in a sentence.
pub fn order(body: &[u8]) -> Result<Order, String> {
    let wanted: Wanted = serde_json::from_slice(body).map_err(|error| {
        format!("an order needs to be one JSON object such as {{\"order\":\"pause\"}}: {error}")
    })?;
    Ok(match wanted {
        Wanted::Pause {} => Order::Pause,
        Wanted::Resume {} => Order::Resume,
        Wanted::Step {} => Order::Step,
        Wanted::Pace { pace } => Order::Pace(pace.parse::<Pace>()?),
        Wanted::HandOver { life } => Order::HandOver(incarnation(&life)?),
    })
}

fn incarnation(life: &str) -> Result<Incarnation, String> {
    let digits = life.len() == 16 && life.bytes().all(|byte| byte.is_ascii_hexdigit());
    let number = u64::from_str_radix(life, 16).ok().filter(|&number| digits && number != 0);
    number.map(Incarnation).ok_or_else(|| format!("a life is sixteen hexadecimal digits, got {life:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_read_and_nonsense_is_refused() {
        for (text, need) in [
            (r#"{"order":"pause"}"#, Order::Pause),
            (r#"{"order":"resume"}"#, Order::Resume),
            (r#"{"order":"step"}"#, Order::Step),
            (r#"{"order":"pace","pace":"max"}"#, Order::Pace(Pace::Max)),
            (r#"{"order":"pace","pace":"2.5"}"#, Order::Pace(Pace::Hertz(2.5))),
            (r#"{"order":"hand_over","life":"00000000000000ff"}"#, Order::HandOver(Incarnation(255))),
        ] {
            assert_eq!(order(text.as_bytes()), Ok(need));
        }
        for text in [
            "",
            "null",
            "[]",
            r#"{"order":"destroy"}"#,
            r#"{"order":"pause","more":1}"#,
            r#"{"order":"pace","pace":"1e99"}"#,
            r#"{"order":"pace","pace":3}"#,
            r#"{"order":"hand_over","life":"ff"}"#,
            r#"{"order":"hand_over","life":"0000000000000000"}"#,
            r#"{"order":"hand_over","life":"+000000000000001"}"#,
            "{\"order\":\"pause\"}\0",
            "\u{ff}\u{fe}",
        ] {
            assert!(order(text.as_bytes()).is_err(), "{text:?}");
        }
    }
}
