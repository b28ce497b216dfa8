//! Folds characters for comparison: lower case, half-width, without accents, simplified characters.
//!
//! This is no Unicode normalization: only what addresses in the languages at hand are written with.

/// Whether `c` only changes the character before it, or has no width.
pub(crate) fn is_combining(c: char) -> bool {
    matches!(c, '\u{0300}'..='\u{036F}' | '\u{200B}'..='\u{200F}' | '\u{FEFF}')
}

/// Full-width forms, typographic hyphens and apostrophes as their plain counterparts.
pub(crate) fn half_width(c: char) -> char {
    match c {
        // Full-width forms stand in the order of ASCII, at this distance.
        '\u{FF01}'..='\u{FF5E}' => char::from_u32(u32::from(c) - 0xFEE0).unwrap_or(c),
        '\u{3000}' => ' ',
        '\u{2010}'..='\u{2015}' | '\u{2212}' => '-',
        '’' | '‘' => '\'',
        _ => c,
    }
}

/// Appends `c` in lower case, without accent, simplified.
pub(crate) fn push_folded(out: &mut String, c: char) {
    // One character may become several.
    for lower in c.to_lowercase() {
        match without_accent(lower) {
            Some(plain) => out.push_str(plain),
            None if is_combining(lower) => {}
            None => out.push(simplified(lower)),
        }
    }
}

/// The plain letters of an accented letter or a ligature.
fn without_accent(c: char) -> Option<&'static str> {
    Some(match c {
        'à' | 'á' | 'â' | 'ã' | 'ä' | 'å' | 'ā' | 'ă' | 'ą' => "a",
        'ç' | 'ć' | 'č' => "c",
        'ď' | 'đ' => "d",
        'è' | 'é' | 'ê' | 'ë' | 'ē' | 'ė' | 'ę' | 'ě' => "e",
        'ğ' => "g",
        'ì' | 'í' | 'î' | 'ï' | 'ī' | 'ı' => "i",
        'ł' => "l",
        'ñ' | 'ń' | 'ň' => "n",
        'ò' | 'ó' | 'ô' | 'õ' | 'ö' | 'ø' | 'ō' | 'ő' => "o",
        'ř' => "r",
        'ś' | 'š' | 'ş' => "s",
        'ť' => "t",
        'ù' | 'ú' | 'û' | 'ü' | 'ū' | 'ů' | 'ű' => "u",
        'ý' | 'ÿ' => "y",
        'ź' | 'ż' | 'ž' => "z",
        'æ' => "ae",
        'œ' => "oe",
        'ß' => "ss",
        _ => return None,
    })
}

/// The simplified form of the traditional and Japanese characters that addresses are written with.
fn simplified(c: char) -> char {
    match c {
        '樓' => '楼',
        '號' => '号',
        '單' => '单',
        '棟' => '栋',
        '門' => '门',
        '層' => '层',
        '請' => '请',
        '這' => '这',
        '個' => '个',
        '後' => '后',
        '給' => '给',
        '遞' => '递',
        '貨' => '货',
        '與' => '与',
        '別' => '别',
        '對' => '对',
        '應' => '应',
        '該' => '该',
        '從' => '从',
        '還' => '还',
        '幫' => '帮',
        '麻' => '麻',
        '煩' => '烦',
        '兩' => '两',
        '壹' => '一',
        '貳' | '贰' => '二',
        '參' | '叁' => '三',
        '肆' => '四',
        '伍' => '五',
        '陸' | '陆' => '六',
        '柒' => '七',
        '捌' => '八',
        '玖' => '九',
        '拾' => '十',
        _ => c,
    }
}
