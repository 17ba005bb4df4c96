//! Dependencies between parameters.

use super::*;

#[test]
fn a_built_in_part_can_be_removed_without_its_need() {
    // An energy limit per metre is built in, with its belt; the set values remove the belt.
    let built_in = with(&[(14, 100.0), (56, 1e-5), (83, 1.0), (59, 10e3)]);
    let check = |(key, value): (u8, f32), set: &[(u8, f32)]| {
        let mut values = built_in;
        set.iter().for_each(|&(key, value)| values[place_of(key).unwrap()] = value);
        check_need(place_of(key).unwrap(), value, &values, &built_in)
    };
    let no_belt = [(56, f32::INFINITY)];
    assert_eq!([check((14, f32::INFINITY), &no_belt), check((83, 0.0), &no_belt)], [Ok(()); 2]);
    assert_eq!(check((14, 50.0), &no_belt), Err(Refusal::NotConfigured));
    // For a plain number, zero does not mean that a part is not present.
    assert_eq!(check((13, 0.0), &no_belt), Err(Refusal::NotConfigured));
    // A built-in value is never refused, except a missing belt scale that something needs.
    let plain = values_of(&config());
    assert!((0..PARAMETERS.len()).all(|place| check_need(place, plain[place], &plain, &plain) == Ok(())));
    assert_eq!([check((14, 100.0), &no_belt), check((56, 1e-5), &[])], [Ok(()); 2]);
    assert_eq!(check((56, f32::INFINITY), &[]), Err(Refusal::NotConfigured));
}

#[test]
fn each_parameter_needs_only_its_own_part() {
    // Beginning of the names of a part, and the parameter that the part needs.
    let parts = [
        ("friction.", "friction.enabled"),
        ("restraint.", "restraint.enabled"),
        ("sweep.", "sweep.time_s"),
        ("burst.duty", "burst.period_s"),
        ("heat_sink.", "heat_sink.ohm_at_25_c"),
        ("supply.", "supply.divider"),
        ("front_end.force_hz", "front_end.newton_per_lsb"),
        ("limits.belt_stop_ms", "front_end.metre_per_count"),
        ("limits.energy_j_per_m", "front_end.metre_per_count"),
    ];
    for parameter in &PARAMETERS {
        let name = parameter.name;
        let expected = match parts.iter().find(|(part, _)| name.starts_with(part)) {
            _ if name == "restraint.enabled" => Some("front_end.metre_per_count"),
            Some((_, with)) if *with != name => Some(*with),
            _ => None,
        };
        let need = need_of(parameter.key).map(|key| PARAMETERS[place_of(key).unwrap()].name);
        assert_eq!(need, expected, "{name}");
    }
}
