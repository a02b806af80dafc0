// Multiples of an angle without a sine and a cosine each.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace alpenglow::ephemeris {

// e^{i k angle} for k in -N .. N.
template <int N>
class Harmonics {
public:
    explicit Harmonics(double angle) {
        const double c = std::cos(angle);
        const double s = std::sin(angle);
        re_[N] = 1.0;
        im_[N] = 0.0;
        for (std::size_t k = 1; k <= N; ++k) {
            re_[N + k] = re_[N + k - 1] * c - im_[N + k - 1] * s;
            im_[N + k] = re_[N + k - 1] * s + im_[N + k - 1] * c;
            re_[N - k] = re_[N + k];
            im_[N - k] = -im_[N + k];
        }
    }
    [[nodiscard]] double re(int k) const { return re_[static_cast<std::size_t>(N + k)]; }
    [[nodiscard]] double im(int k) const { return im_[static_cast<std::size_t>(N + k)]; }

private:
    std::array<double, 2 * N + 1> re_{};
    std::array<double, 2 * N + 1> im_{};
};

struct SineCosine {
    double sine;
    double cosine;
};

// Sine and cosine of a term's combination of the moon's four arguments.
struct LunarHarmonics {
    Harmonics<6> d, m, m_moon, f;

    template <class Term>
    [[nodiscard]] SineCosine operator()(const Term& k) const {
        const double ar = d.re(k.d) * m.re(k.m) - d.im(k.d) * m.im(k.m);
        const double ai = d.re(k.d) * m.im(k.m) + d.im(k.d) * m.re(k.m);
        const double br = m_moon.re(k.m_moon) * f.re(k.f) - m_moon.im(k.m_moon) * f.im(k.f);
        const double bi = m_moon.re(k.m_moon) * f.im(k.f) + m_moon.im(k.m_moon) * f.re(k.f);
        return {ar * bi + ai * br, ar * br - ai * bi};
    }
};

} // namespace alpenglow::ephemeris
