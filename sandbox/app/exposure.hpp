// Automatic exposure from light that is known, not from a histogram of the image: it is steady, costs nothing and gives
// the same bytes on every run.
#pragma once

namespace alpenglow::sandbox {

// The factor from radiance (cd/m^2) to scene value for a view whose average luminance is `luminance_cd_m2`, so that
// the average lands on a key that falls with the light: noon is bright, a moonlit night stays dark (Krawczyk,
// Myszkowski, Seidel 2005, eq. 11: key = 1.03 - 2 / (2 + log10(L + 1)), bounded from below for moonless nights).
// `bias_ev` brightens by powers of two, -20 .. 20, and counts as 0
// beyond. Any input gives a positive finite factor.
[[nodiscard]] float automatic_exposure(float luminance_cd_m2, float bias_ev);

// Moves `current` towards `target` on a logarithmic scale, with the eye's time constants: about 0.4 s towards bright
// light, 1.5 s towards dark.
[[nodiscard]] float adapt_exposure(float current, float target, float dt_s);

} // namespace alpenglow::sandbox
