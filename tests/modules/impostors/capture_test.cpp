#include <alpenglow/impostors/capture.hpp>
#include <alpenglow/impostors/error.hpp>
#include <alpenglow/impostors/reproject.hpp>

#include "blob_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow::impostors {
namespace {

constexpr double degree = 0.017453292519943295;

class Pictures : public ::testing::TestWithParam<Representation> {
protected:
    test::BlobCloud cloud = test::make_blob_cloud(80, 5);
    double distance = 4.0;

    Capture take(int texels, int layers = 8, bool sharpen = true) const {
        CaptureSettings settings;
        settings.sharpen = sharpen;
        settings.representation = GetParam();
        settings.layers = layers;
        const auto frustum = fit_frustum(cloud.bounds, {0, -distance, 0}, {0, 0, 1}, texels);
        return std::move(capture(cloud.bounds, *frustum, settings, test::drawable(cloud)).value());
    }
    Frustum orbit(double angle_rad, int pixels) const {
        const glm::dvec3 e = distance * glm::dvec3(std::sin(angle_rad), -std::cos(angle_rad), 0.0);
        return look_at(e, cloud.bounds.centre_m, {0, 0, 1}, 2.0 * std::atan(1.0 / std::sqrt(distance * distance - 1.0)),
                       pixels, pixels);
    }
    static std::vector<glm::vec4> shown(const Capture& c, const Frustum& view, const DrawSettings& settings = {}) {
        std::vector<glm::vec4> image(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height),
                                     glm::vec4(0.0F));
        draw(c, view, settings, image);
        return image;
    }
};

// From where it was taken, with its own window, a picture is what direct drawing gives: every representation, to
// rounding.
TEST_P(Pictures, ExactWhereItWasTaken) {
    const Capture c = take(64, 1, false);
    const auto exact = test::draw_directly(cloud, c.view);
    EXPECT_LT(test::relative_rmse(shown(c, c.view), exact), 2e-5);
    // With layers colours are blended in other steps, alpha is still the same.
    const Capture layered = take(64, 8, false);
    EXPECT_LT(test::relative_rmse(shown(layered, c.view), exact), 2e-3);
}

// What sharpening is for: off the texels' centres, bilinear filtering loses less than half of what it would.
TEST_P(Pictures, SharpeningHalvesWhatFilteringLoses) {
    const Frustum view = orbit(0.0, 61);
    const auto exact = test::draw_directly(cloud, view);
    EXPECT_LT(test::relative_rmse(shown(take(64), view), exact),
              0.6 * test::relative_rmse(shown(take(64, 8, false), view), exact));
}

TEST_P(Pictures, TwoHundredthsAtOneDegree) {
    const Capture c = take(100);
    const Frustum view = orbit(degree, 96);
    EXPECT_LE(test::relative_rmse(shown(c, view), test::draw_directly(cloud, view)), 0.02);
}

// Rolling the camera changes nothing but the picture's place.
TEST_P(Pictures, CameraRoll) {
    const Capture c = take(100);
    Frustum view = orbit(0.5 * degree, 96);
    const auto upright = test::relative_rmse(shown(c, view), test::draw_directly(cloud, view));
    const glm::dvec3 right = view.right;
    view.right = (right + 2.0 * view.up) / std::sqrt(5.0);
    view.up = (view.up - 2.0 * right) / std::sqrt(5.0);
    const auto rolled = test::relative_rmse(shown(c, view), test::draw_directly(cloud, view));
    EXPECT_LE(rolled, 1.5 * upright + 1e-3);
}

// Coverage: what all layers show together has the same mean in every mip.
TEST_P(Pictures, MipsKeepCoverage) {
    const Capture c = take(77, 8, false);
    double base = 0.0;
    for (std::size_t n = 0; n < c.layers.front().mips.size(); ++n) {
        double sum = 0.0;
        for (std::size_t i = 0; i < c.layers.front().mips[n].colour.size(); ++i) {
            double left = 1.0;
            for (const Layer& layer : c.layers) {
                const glm::vec4& t = layer.mips[n].colour[i];
                ASSERT_TRUE(t.w >= 0.0F && t.w <= 1.0F);
                left *= 1.0 - static_cast<double>(t.w);
            }
            sum += 1.0 - left;
        }
        const double coverage = sum * std::pow(4.0, static_cast<double>(n));
        base = n == 0 ? coverage : base;
        EXPECT_NEAR(coverage, base, 1e-3 * base) << n;
    }
    EXPECT_EQ(c.layers.front().mips.back().width, 1);
    EXPECT_EQ(c.layers.front().mips.back().height, 1);
}

// Far away the mean over the picture is what direct drawing gives: neither dark nor bright rims, neither loss of
// matter.
TEST_P(Pictures, NoHalosWhenSmall) {
    const Capture c = take(96);
    Frustum view = orbit(0.0, 96);
    view.width = view.height = 12;
    const auto small = shown(c, view);
    const Frustum fine = orbit(0.0, 96);
    const auto exact = test::draw_directly(cloud, fine);
    glm::dvec4 a(0.0);
    glm::dvec4 b(0.0);
    for (const glm::vec4& t : small) {
        a += glm::dvec4(t) / static_cast<double>(small.size());
    }
    for (const glm::vec4& t : exact) {
        b += glm::dvec4(t) / static_cast<double>(exact.size());
    }
    for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(a[i] / b[i], 1.0, 0.03);
    }
    // Un-premultiplied colours stay within those of the source: a halo would leave that range.
    float least = 1e9F;
    float greatest = 0.0F;
    for (const glm::vec4& t : exact) {
        if (t.w > 0.02F) {
            least = std::min(least, t.x / t.w);
            greatest = std::max(greatest, t.x / t.w);
        }
    }
    for (const glm::vec4& t : small) {
        if (t.w > 0.05F) {
            EXPECT_GE(t.x / t.w, 0.97F * least);
            EXPECT_LE(t.x / t.w, 1.03F * greatest);
        }
    }
}

// A change of exposure or of a light's colour is a factor: the drawn picture is what a new capture would be.
TEST_P(Pictures, LightsChangeWithoutACapture) {
    const Capture c = take(64);
    const Frustum view = orbit(0.3 * degree, 64);
    Lights sunset;
    sunset.key = {40.0F, 11.0F, 3.0F};
    sunset.fill = {0.2F, 0.4F, 0.9F};
    DrawSettings settings;
    settings.gain = light_gain(c.lights, sunset);
    CaptureSettings again;
    again.representation = GetParam();
    again.lights = sunset;
    const auto fresh = capture(cloud.bounds, c.view, again, test::drawable(cloud));
    ASSERT_TRUE(fresh);
    EXPECT_LT(test::relative_rmse(shown(c, view, settings), shown(*fresh, view)), 1e-5);
}

TEST_P(Pictures, NotANumberNeverLeavesACapture) {
    std::mt19937 random(3);
    const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0F,
                         -1e30F};
    std::size_t put = 0;
    const Drawable broken = [&](const CaptureRequest& request, std::span<SlabImage> slabs) -> Status {
        test::draw_blobs(cloud, request, slabs);
        for (SlabImage& slab : slabs) {
            for (std::size_t i = 0; i < slab.colour.size(); ++i) {
                switch (random() % 40) {
                case 0:
                    slab.colour[i][static_cast<int>(random() % 4)] = bad[random() % 4];
                    break;
                case 1:
                    slab.fill[i].y = bad[random() % 4];
                    break;
                case 2:
                    slab.depth[i].x = bad[random() % 2];
                    break;
                case 3:
                    slab.depth[i].y = bad[random() % 2];
                    break;
                case 4:
                    slab.colour[i].w = 3.0F;
                    break;
                default:
                    continue;
                }
                ++put;
            }
        }
        return Ok{};
    };
    CaptureSettings settings;
    settings.representation = GetParam();
    const auto frustum = fit_frustum(cloud.bounds, {0, -4, 0}, {0, 0, 1}, 48);
    const auto c = capture(cloud.bounds, *frustum, settings, broken);
    ASSERT_TRUE(c);
    EXPECT_GT(c->rejected_texels, put / 2);
    EXPECT_LE(c->rejected_texels, put);
    const auto finite = [](const glm::vec4& t) {
        return std::isfinite(t.x) && std::isfinite(t.y) && std::isfinite(t.z) && t.w >= 0.0F && t.w <= 1.0F;
    };
    for (const Layer& layer : c->layers) {
        for (const MipLevel& mip : layer.mips) {
            EXPECT_TRUE(std::all_of(mip.colour.begin(), mip.colour.end(), finite));
        }
        EXPECT_TRUE(std::all_of(layer.warp.begin(), layer.warp.end(), [](float s) { return std::isfinite(s); }));
    }
    for (const double angle : {0.0, 1.0, 20.0, 90.0, 180.0}) {
        for (const glm::vec4& t : shown(*c, orbit(angle * degree, 40))) {
            ASSERT_TRUE(finite(t) || t.w <= 1.0001F);
            ASSERT_TRUE(std::isfinite(t.x + t.y + t.z + t.w));
        }
    }
    EXPECT_TRUE(std::isfinite(predicted_error(*c, {1, 1, 1})));
}

// An opaque object in the middle hides what is behind it and is veiled by what is in front: against direct drawing of
// the part in front.
TEST_P(Pictures, DepthTestInsideTheCloud) {
    const Capture c = take(100, 16);
    const Frustum view = orbit(0.0, 96);
    const std::vector<float> depth(static_cast<std::size_t>(view.width * view.height), 3.9F);
    DrawSettings settings;
    settings.scene_depth_m = depth;
    const auto front = shown(c, view, settings);
    CaptureRequest request;
    request.view = view;
    request.edges_m = {0.0, 3.9};
    std::vector<SlabImage> slab(1);
    slab[0].colour.assign(depth.size(), glm::vec4(0.0F));
    slab[0].depth.assign(depth.size(), glm::vec2(0.0F));
    test::draw_blobs(cloud, request, slab);
    for (std::size_t i = 0; i < depth.size(); ++i) {
        slab[0].colour[i] += glm::vec4(slab[0].fill[i], 0.0F);
    }
    const bool one = GetParam() == Representation::plane || GetParam() == Representation::depth_warp;
    EXPECT_LT(test::relative_rmse(front, slab[0].colour), one ? 0.25 : 0.03);
}

// Front and back of a cut compose to the whole, wherever the cut lies.
TEST_P(Pictures, SlicesComposeToTheWhole) {
    const Capture c = take(64);
    const Frustum view = orbit(0.7 * degree, 64);
    const auto whole = shown(c, view);
    for (const double cut : {3.0001, 3.4, 4.0, 4.5, 4.9999, 7.0}) {
        DrawSettings front;
        front.far_m = cut;
        DrawSettings back;
        back.near_m = cut;
        auto both = shown(c, view, back);
        over(shown(c, view, front), both);
        EXPECT_LT(test::relative_rmse(both, whole), 0.01) << cut;
    }
}

INSTANTIATE_TEST_SUITE_P(All, Pictures,
                         ::testing::Values(Representation::plane, Representation::layers, Representation::depth_warp,
                                           Representation::warped_layers));

TEST(Capture, RefusesWhatItCannotKeep) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    auto frustum = *fit_frustum(bounds, {0, -4, 0}, {0, 0, 1}, 16);
    const Drawable nothing = [](const CaptureRequest&, std::span<SlabImage>) -> Status { return Ok{}; };
    const Drawable resizes = [](const CaptureRequest&, std::span<SlabImage> slabs) -> Status {
        slabs[0].colour.resize(3);
        return Ok{};
    };
    const Drawable fails = [](const CaptureRequest&, std::span<SlabImage>) -> Status {
        return Error{"device lost", "queue", ""};
    };
    EXPECT_TRUE(capture(bounds, frustum, CaptureSettings{}, nothing));
    const auto resized = capture(bounds, frustum, CaptureSettings{}, resizes);
    ASSERT_FALSE(resized);
    EXPECT_NE(resized.error().message().find("256"), std::string::npos);
    const auto failed = capture(bounds, frustum, CaptureSettings{}, fails);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().what, "device lost");
    const double backwards[] = {4.0, 3.0};
    EXPECT_FALSE(capture(bounds, frustum, backwards, {}, nothing));
    frustum.width = 0;
    EXPECT_FALSE(capture(bounds, frustum, CaptureSettings{}, nothing));
}

TEST(Capture, SlabsShareParallaxEvenly) {
    const Sphere bounds{{0, 0, 0}, 1.0};
    const auto frustum = *fit_frustum(bounds, {0, -4, 0}, {0, 0, 1}, 16);
    const auto edges = slab_edges(bounds, frustum, 8);
    EXPECT_DOUBLE_EQ(edges.front(), 3.0);
    EXPECT_DOUBLE_EQ(edges.back(), 5.0);
    for (std::size_t k = 0; k < 8; ++k) {
        EXPECT_NEAR(1.0 / edges[k] - 1.0 / edges[k + 1], (1.0 / 3.0 - 1.0 / 5.0) / 8.0, 1e-12);
    }
}

TEST(ShareInFront, MomentsOfAnEvenSpread) {
    // Matter evenly over s in [-0.5, 0.5]: variance 1 / 12.
    EXPECT_NEAR(share_in_front(1.0F, 0.0F, 1.0F / 12.0F, 0.0F), 0.5F, 1e-6F);
    EXPECT_NEAR(share_in_front(1.0F, 0.0F, 1.0F / 12.0F, 0.25F), 0.75F, 1e-6F);
    EXPECT_EQ(share_in_front(1.0F, 0.0F, 1.0F / 12.0F, -0.6F), 0.0F);
    EXPECT_EQ(share_in_front(1.0F, 0.0F, 1.0F / 12.0F, 0.6F), 1.0F);
    EXPECT_EQ(share_in_front(0.5F, 0.1F, 0.02F, 0.2F), 1.0F); // a surface at 0.2: in front of what is at it
    EXPECT_EQ(share_in_front(0.5F, 0.1F, 0.02F, 0.19F), 0.0F);
}

// Vectors of pixels see what single ones see: every representation, from near and far, with mips, with a fill light,
// with odd widths and open edges, with either filter, sharpened or not.
TEST(Resampling, VectorsAndScalarsDrawTheSame) {
    const test::BlobCloud cloud = test::make_blob_cloud(60, 5);
    int drawn = 0;
    for (const Representation kind :
         {Representation::plane, Representation::layers, Representation::depth_warp, Representation::warped_layers}) {
        for (const bool open_edges : {false, true}) {
            CaptureSettings settings;
            settings.representation = kind;
            settings.layers = 5;
            settings.open_edges = open_edges;
            settings.sharpen = kind != Representation::layers;
            const auto picture = capture(cloud.bounds, *fit_frustum(cloud.bounds, {0, -4, 0}, {0, 0, 1}, 61), settings,
                                         test::drawable(cloud));
            ASSERT_TRUE(picture);
            for (const glm::dvec3& eye : {glm::dvec3(0, -4, 0), glm::dvec3(0.2, -3.9, 0.1), glm::dvec3(1.5, -3.0, -0.7),
                                          glm::dvec3(-2.0, -12.0, 3.0), glm::dvec3(0.0, 4.0, 0.5)}) {
                const Frustum view = look_at(eye, {0.1, 0.0, 0.05}, {0.1, 0, 1}, 0.6, 83, 47);
                DrawSettings draw_settings;
                draw_settings.gain.key = glm::vec3(1.5F, 1.0F, 0.5F);
                draw_settings.gain.fill = glm::vec3(0.5F, 1.0F, 2.0F);
                draw_settings.weight = 0.75F;
                draw_settings.filter = ++drawn % 2 == 0 ? Filter::cubic : Filter::bilinear;
                std::vector<glm::vec4> a(83 * 47, glm::vec4(0.0F));
                std::vector<glm::vec4> b(a);
                EXPECT_EQ(draw(*picture, view, draw_settings, a), draw_scalar(*picture, view, draw_settings, b));
                double most = 0.0;
                for (std::size_t i = 0; i < a.size(); ++i) {
                    for (int c = 0; c < 4; ++c) {
                        most = std::max(most, static_cast<double>(std::abs(a[i][c] - b[i][c])));
                    }
                }
                // A texel on the border of a block, or of a fixed point's last step, may be taken either way.
                EXPECT_LT(test::relative_rmse(a, b), 1e-3) << static_cast<int>(kind);
                EXPECT_LT(most, 0.02) << static_cast<int>(kind);
            }
        }
    }
}

// The cubic filter: where a picture is enlarged twofold it loses less than bilinear filtering, and leaves the range of
// light and matter nowhere, sharpened or not.
TEST(Resampling, CubicLosesLess) {
    const test::BlobCloud cloud = test::make_blob_cloud(80, 5);
    const Frustum frustum = *fit_frustum(cloud.bounds, {0, -4, 0}, {0, 0, 1}, 40);
    const Frustum view = look_at({0, -4, 0}, {0, 0, 0}, {0, 0, 1}, 0.5, 88, 88);
    const auto exact = test::draw_directly(cloud, view);
    const auto loss = [&](Filter filter, bool sharpen) {
        CaptureSettings settings;
        settings.sharpen = sharpen;
        const auto picture = capture(cloud.bounds, frustum, settings, test::drawable(cloud));
        EXPECT_EQ(picture->sharpened, sharpen);
        DrawSettings s;
        s.filter = filter;
        std::vector<glm::vec4> image(exact.size(), glm::vec4(0.0F));
        draw(*picture, view, s, image);
        for (const glm::vec4& t : image) {
            EXPECT_TRUE(t.x >= 0.0F && t.w >= 0.0F && t.w <= 1.0001F);
        }
        return test::relative_rmse(image, exact);
    };
    const double least = loss(Filter::cubic, false);
    EXPECT_LT(least, 0.6 * loss(Filter::bilinear, false));
    EXPECT_LT(least, loss(Filter::bilinear, true));
    EXPECT_LT(loss(Filter::cubic, true), loss(Filter::bilinear, false));
}

// Vectors of texels keep what single ones keep: every kind, with and without fill light, sharpening, open edges, bent
// nodes and mips; odd sizes; texels that are not physical.
TEST(Keeping, VectorsAndScalarsKeepTheSame) {
    const test::BlobCloud cloud = test::make_blob_cloud(12, 8);
    const auto close = [](const auto& a, const auto& b, float scale, const char* what) {
        ASSERT_EQ(a.size(), b.size()) << what;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const auto d = glm::abs(a[i] - b[i]);
            for (int c = 0; c < static_cast<int>(sizeof(d) / sizeof(float)); ++c) {
                ASSERT_LE(d[c], 2e-4F * scale) << what << " at " << i << " channel " << c;
            }
        }
    };
    int variant = 0;
    for (const Representation kind :
         {Representation::plane, Representation::layers, Representation::depth_warp, Representation::warped_layers}) {
        for (const int texels : {1, 5, 16, 61, 72}) {
            CaptureSettings settings;
            settings.representation = kind;
            settings.layers = 6;
            settings.sharpen = ++variant % 3 != 0;
            settings.open_edges = variant % 2 == 0;
            settings.warp_cell = variant % 4 == 1 ? 8 : 0;
            settings.mips = variant % 5 != 0;
            const bool fill = variant % 7 < 4;
            const bool broken = variant % 6 == 2;
            const bool inside = variant % 8 == 3;
            const Drawable drawable = [&](const CaptureRequest& request, std::span<SlabImage> slabs) -> Status {
                test::draw_blobs(cloud, request, slabs);
                for (SlabImage& slab : slabs) {
                    if (!fill) {
                        slab.fill.clear();
                    }
                    if (broken) {
                        slab.colour[slab.colour.size() / 3].y = std::numeric_limits<float>::quiet_NaN();
                        slab.depth[slab.colour.size() / 2].x = std::numeric_limits<float>::infinity();
                        slab.colour[slab.colour.size() / 2 + 1].w = 1.5F;
                    }
                }
                return Ok{};
            };
            Frustum frustum = *fit_frustum(cloud.bounds, {0.4, -4, 0.3}, {0, 0, 1}, std::max(3, texels));
            frustum.width = texels;
            frustum.height = std::max(1, texels * 3 / 4);
            if (inside) {
                frustum = screen_aligned(look_at({0.1, -0.2, 0.05}, {1, 1, 0}, {0, 0, 1}, 1.2, texels, texels), 1.0);
            }
            const auto a = capture(cloud.bounds, frustum, settings, drawable);
            const auto b = capture_scalar(cloud.bounds, frustum, settings, drawable);
            ASSERT_TRUE(a);
            ASSERT_TRUE(b);
            EXPECT_EQ(a->rejected_texels, b->rejected_texels);
            close(std::vector{a->mean}, std::vector{b->mean}, 1.0F, "mean");
            ASSERT_EQ(a->layers.size(), b->layers.size());
            for (std::size_t k = 0; k < a->layers.size(); ++k) {
                const Layer& la = a->layers[k];
                const Layer& lb = b->layers[k];
                EXPECT_NEAR(la.plane_m, lb.plane_m, 1e-5 * lb.plane_m);
                EXPECT_EQ(la.occupied, lb.occupied);
                ASSERT_EQ(la.warp.size(), lb.warp.size());
                for (std::size_t i = 0; i < la.warp.size(); ++i) {
                    ASSERT_NEAR(la.warp[i], lb.warp[i], 2e-4F) << i;
                }
                ASSERT_EQ(la.mips.size(), lb.mips.size());
                for (std::size_t n = 0; n < la.mips.size(); ++n) {
                    close(la.mips[n].colour, lb.mips[n].colour, 2.0F, "colour");
                    close(la.mips[n].fill, lb.mips[n].fill, 1.0F, "fill");
                    close(la.mips[n].depth, lb.mips[n].depth, 1.0F, "depth");
                }
            }
            const Sensitivity& sa = a->sensitivity;
            const Sensitivity& sb = b->sensitivity;
            EXPECT_NEAR(sa.resample, sb.resample, 1e-3 * sb.resample);
            for (const auto& [ma, mb] : {std::pair{sa.radiance, sb.radiance}, std::pair{sa.alpha, sb.alpha}}) {
                const double largest = mb[0][0] + mb[1][1] + mb[2][2];
                for (int i = 0; i < 3; ++i) {
                    for (int j = 0; j < 3; ++j) {
                        EXPECT_NEAR(ma[i][j], mb[i][j], 1e-3 * largest) << texels << " " << static_cast<int>(kind);
                    }
                }
            }
        }
    }
}

// Without mips there is level 0 alone, and what is drawn near its own size is the same.
TEST(Keeping, MipsCanBeLeftOut) {
    const test::BlobCloud cloud = test::make_blob_cloud(30, 8);
    const Frustum frustum = *fit_frustum(cloud.bounds, {0, -4, 0}, {0, 0, 1}, 48);
    CaptureSettings settings;
    const auto with = capture(cloud.bounds, frustum, settings, test::drawable(cloud));
    settings.mips = false;
    const auto without = capture(cloud.bounds, frustum, settings, test::drawable(cloud));
    ASSERT_TRUE(with && without);
    EXPECT_EQ(without->layers.front().mips.size(), 1U);
    const Frustum view = look_at({0.1, -4, 0}, {0, 0, 0}, {0, 0, 1}, 0.4, 48, 48);
    std::vector<glm::vec4> a(48 * 48, glm::vec4(0.0F));
    std::vector<glm::vec4> b(a);
    draw(*with, view, {}, a);
    draw(*without, view, {}, b);
    EXPECT_EQ(a, b);
}

} // namespace
} // namespace alpenglow::impostors
