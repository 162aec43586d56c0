"""Pictures of an operator's controls: an emergency stop (ISO 13850, IEC 60073), buttons and a lamp.

The classes `up` and `down` are the two positions of the emergency stop; `.lit` around a lamp lights it.
"""

MUSHROOM = (
    '<svg viewBox="0 0 112 112"><rect x="2" y="2" width="108" height="108" rx="10" fill="#f2c500" stroke="#8a7100"/>'
    '<circle cx="56" cy="56" r="45" fill="none" stroke="#8a7100" stroke-opacity=".45"/>'
    '<g class="up"><circle cx="56" cy="63" r="39" fill="#000" opacity=".22"/>'
    '<circle cx="56" cy="56" r="38" fill="#8f0d13"/>'
    '<circle cx="56" cy="54" r="37" fill="#cf1a22"/><circle cx="56" cy="53" r="28" fill="#da2b32"/>'
    '<g fill="none" stroke="#fff" stroke-width="2.5" stroke-linecap="round"><path d="M41 44a18 18 0 0 1 15-9"/>'
    '<path d="M71 62a18 18 0 0 1-15 9"/></g><path d="M55 30l8 5-8 5zM57 76l-8-5 8-5z" fill="#fff"/></g>'
    '<g class="down"><circle cx="56" cy="56" r="38" fill="#5f070c"/><circle cx="56" cy="58" r="33" fill="#a91118"/>'
    '<circle cx="56" cy="58" r="25" fill="#b3161d"/>'
    '<path d="M23 58a33 33 0 0 1 66 0 33 29 0 0 0-66 0z" fill="#000" opacity=".28"/>'
    '<g fill="none" stroke="#fff" stroke-width="2.5" stroke-linecap="round"><path d="M43 49a15 15 0 0 1 13-7"/>'
    '<path d="M69 67a15 15 0 0 1-13 7"/></g><path d="M55 37.5l7 4.5-7 4.5zM57 78.5l-7-4.5 7-4.5z" fill="#fff"/></g>'
    "</svg>"
)
_BEZEL = '<circle cx="36" cy="36" r="34" class="bezel"/><circle cx="36" cy="36" r="27" class="ring"/>'
PUSH = f'<svg viewBox="0 0 72 72">{_BEZEL}<circle cx="36" cy="35" r="25" class="cap"/></svg>'
START = (
    f'<svg viewBox="0 0 72 72">{_BEZEL}<circle cx="36" cy="35" r="25" class="cap"/>'
    '<path d="M31 26l14 9-14 9z" class="glyph"/></svg>'
)
LAMP = (
    '<svg viewBox="0 0 32 32"><circle cx="16" cy="16" r="14" class="bezel"/>'
    '<circle cx="16" cy="16" r="9" class="glass"/></svg>'
)
