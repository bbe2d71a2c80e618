//! What a page may do to its own mission: have another planner take over, go away and come back.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use browser::{Request, Session, Turnover};
use contract::MonotonicNs;

fn request(scenario: &str) -> Request {
    Request { scenario: Some(scenario.into()), seed: 3, ..Request::default() }
}

fn begin(scenario: &str) -> Session {
    let request = request(scenario);
    let mut now_ns = 0;
    let clock = move || {
        now_ns += 1_000_000;
        MonotonicNs(now_ns)
    };
    Session::begin(&request, &Arc::from([]), Box::new(clock)).unwrap()
}

/// Lets the mission go on until that decision is due.
fn fly_to(session: &mut Session, decision: u64) {
    while session.decision().0 < decision {
        assert!(!session.turn().unwrap(), "the mission is over before decision {decision}");
    }
}

fn frames(session: &mut Session) -> Vec<(&'static str, String)> {
    std::iter::from_fn(|| session.frame(MonotonicNs(1))).map(|frame| (frame.event, frame.data)).collect()
}

/// Flies a mission in which another planner takes over at each decision of `turnovers`; its digest, and that of the same mission
/// flown at once by its link.
fn handed_over(scenario: &str, first: &str, turnovers: &[(u64, &str)]) -> [String; 2] {
    let mut planners = vec![Turnover { from: 0, planner: first.into() }];
    let mut session = begin(scenario);
    for (from, planner) in turnovers {
        fly_to(&mut session, *from);
        session.hand_over(planner).unwrap();
        // A command that is under way already is executed first.
        assert!(!session.turn().unwrap());
        planners.push(Turnover { from: session.decision().0, planner: (*planner).into() });
    }
    while !session.turn().unwrap() {}
    let request = Request { planners, ..request(scenario) };
    [session.digest(), browser::fly(&request, &Arc::from([])).unwrap().digest]
}

/// P-BROWSER-HAND-OVER: On the page without a server, a planner that takes over commands every
/// robot from that robot's next free decision on, and the link of what was flown repeats the
/// mission.
#[test]
fn who_is_handed_over_to_commands_every_robot_from_the_next_decision_on() {
    for (scenario, first) in [("hard", "mdp"), ("coverage", "cover_frontier")] {
        let unchanged = browser::fly(&request(scenario), &Arc::from([])).unwrap().digest;
        let suited = begin(scenario).suited().to_vec();
        assert!(suited.contains(&first) && suited.len() > 1, "{suited:?}");
        let mut changed = 0;
        for planner in suited {
            let [live, at_once] = handed_over(scenario, first, &[(5, planner)]);
            assert_eq!(live, at_once, "{scenario}: {planner} after decision 5");
            changed += u32::from(live != unchanged);
            let [live, at_once] = handed_over(scenario, first, &[(3, planner), (6, first)]);
            assert_eq!(live, at_once, "{scenario}: {planner} after 3, {first} after 6");
        }
        assert!(changed > 0, "{scenario}: some planner decides otherwise");
    }
}

#[test]
fn nobody_is_handed_over_to_who_does_not_suit_the_mission() {
    let mut hopper = begin("hard");
    let error = hopper.hand_over("cover_frontier").unwrap_err();
    assert!(error.contains("mdp") && error.contains("cover_frontier"), "{error}");
    let mut scouted = begin("rover-helicopter");
    assert!(scouted.suited().is_empty(), "robots of different kinds keep their planners");
    let error = scouted.hand_over("rrt_star_ett").unwrap_err();
    assert!(error.contains("keep the planners that its scenario names"), "{error}");
}

/// P-BROWSER-REWIND: On the page without a server, a tab that was away gets everything that a new
/// one gets, policies included, and both continue alike.
#[test]
fn a_page_that_comes_back_is_told_what_one_is_told_that_has_just_come() {
    for scenario in ["hard", "coverage", "rover-helicopter"] {
        let (mut back, mut new) = (begin(scenario), begin(scenario));
        for decision in 1..=9 {
            fly_to(&mut new, decision);
            fly_to(&mut back, decision);
            // One decision is left unread.
            if decision < 9 {
                assert!(!frames(&mut back).is_empty());
            }
        }
        back.rewind();
        let told = frames(&mut back);
        assert_eq!(told.first().map(|(event, _)| *event), Some("mission"), "{scenario}");
        assert_eq!(told, frames(&mut new), "{scenario}");
        fly_to(&mut new, 12);
        fly_to(&mut back, 12);
        assert_eq!(frames(&mut back), frames(&mut new), "{scenario}");
    }
}

/// P-BROWSER-REWIND. A page that follows policies, leaves and comes back gets the newest.
#[test]
fn a_page_that_comes_back_to_policies_is_told_the_newest() {
    let mut session = begin("hard");
    session.follow_policies(true);
    fly_to(&mut session, 6);
    let policies = |session: &mut Session| -> Vec<String> {
        let policies = frames(session).into_iter().filter(|(event, _)| *event == "policy");
        policies.map(|(_, data)| data).collect()
    };
    let before = policies(&mut session);
    assert!(!before.is_empty(), "the planner has policies");
    assert!(policies(&mut session).is_empty(), "told once");
    session.follow_policies(false);
    session.follow_policies(true);
    session.rewind();
    assert_eq!(policies(&mut session).last(), before.last());
}
