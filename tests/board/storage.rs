//! Flash pages of the settings.

use nucleo_g474re::pages::{PAGE, PAGES, SECOND_BANK, SETTINGS, SIZE, START, WORD, number};

#[test]
fn the_settings_are_the_last_pages_of_the_second_bank() {
    assert_eq!(START + SIZE, 0x0808_0000);
    let pages: Vec<_> = (0..PAGES).map(|page| number(START + page * PAGE)).collect();
    assert_eq!(pages, (120..128).collect::<Vec<_>>());
    const { assert!(START > SECOND_BANK) };
    assert_eq!((SETTINGS.address(PAGE, SIZE, PAGE), SETTINGS.address(PAGE + SIZE, WORD, WORD)), (Some(START), None));
}
