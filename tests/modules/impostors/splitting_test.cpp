#include <alpenglow/impostors/capture.hpp>
#include <alpenglow/impostors/reproject.hpp>
#include <alpenglow/impostors/splitting.hpp>

#include "blob_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace alpenglow::impostors {
namespace {

const Frustum view = look_at({0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0.8, 72, 72);

// A translucent disc facing the view.
struct Disc {
    Sphere bounds;
    glm::vec4 colour; // premultiplied
};
void draw_disc(const Disc& disc, std::span<glm::vec4> image) {
    std::fill(image.begin(), image.end(), glm::vec4(0.0F));
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const glm::dvec3 p = disc.bounds.centre_m.y * view.direction(x + 0.5, y + 0.5);
            if (glm::length(p - disc.bounds.centre_m) < disc.bounds.radius_m) {
                image[static_cast<std::size_t>(y * view.width + x)] = disc.colour;
            }
        }
    }
}

TEST(Splitting, PiecesTileTheirVolumeAndObjectsLieBetween) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int n = 0; n < 200; ++n) {
        const Sphere cloud{{0, 10, 0}, 3.0};
        std::vector<Sphere> objects;
        for (int k = 0; k < n % 12; ++k) {
            objects.push_back({{uniform(random), 10.0 + 2.5 * uniform(random), uniform(random)}, 0.1});
        }
        const auto items = order_back_to_front({&cloud, 1}, objects, view);
        double until = 13.0;
        std::size_t pieces = 0;
        for (const OrderedItem& item : items) {
            if (item.object) { // drawn exactly at its own depth: behind are all deeper pieces, in front all others
                EXPECT_NEAR(objects[item.index].centre_m.y, until, 1e-9);
            } else {
                EXPECT_NEAR(item.far_m, until, 1e-9);
                until = item.near_m;
                ++pieces;
            }
        }
        EXPECT_NEAR(until, 7.0, 1e-9);
        EXPECT_EQ(pieces, objects.size() + 1);
    }
}

TEST(Splitting, ObjectsOutsideCutNothing) {
    const Sphere cloud{{0, 10, 0}, 3.0};
    const Sphere objects[] = {{{0, 5, 0}, 0.5}, {{0, 15, 0}, 0.5}, {{5, 10, 0}, 0.5}, {{0, -5, 0}, 0.5}};
    const auto items = order_back_to_front({&cloud, 1}, objects, view);
    ASSERT_EQ(items.size(), 4U); // the one behind the eye is left out
    const auto place = [&](bool object, std::size_t index) {
        return std::find_if(items.begin(), items.end(),
                            [&](const OrderedItem& i) { return i.object == object && i.index == index; });
    };
    EXPECT_LT(place(true, 1), place(false, 0));
    EXPECT_LT(place(false, 0), place(true, 0));
}

// Disjoint spheres of all sizes: on every ray the order is right.
TEST(Splitting, DisjointSpheresInTrueOrder) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int n = 0; n < 50; ++n) {
        std::vector<Sphere> volumes;
        while (volumes.size() < 20) {
            const Sphere s{{8.0 * uniform(random), 12.0 + 11.0 * uniform(random), 8.0 * uniform(random)},
                           1.6 + 1.5 * uniform(random)};
            if (glm::length(s.centre_m) > s.radius_m &&
                std::all_of(volumes.begin(), volumes.end(), [&](const Sphere& o) {
                    return glm::length(o.centre_m - s.centre_m) > o.radius_m + s.radius_m;
                })) {
                volumes.push_back(s);
            }
        }
        const auto items = order_back_to_front(volumes, {}, view);
        for (int k = 0; k < 300; ++k) {
            const glm::dvec3 ray =
                glm::normalize(view.direction(36.0 + 36.0 * uniform(random), 36.0 + 36.0 * uniform(random)));
            double last = 1e9;
            for (const OrderedItem& item : items) {
                const Sphere& s = volumes[item.index];
                const double t = glm::dot(s.centre_m, ray);
                const double h = s.radius_m * s.radius_m - glm::dot(s.centre_m, s.centre_m) + t * t;
                if (h > 0.0 && t > 0.0) {
                    EXPECT_LT(t - std::sqrt(h), last);
                    last = t - std::sqrt(h);
                }
            }
        }
    }
}

// Two overlapping clouds and translucent discs in, between and beside them, against marching both at once.
TEST(Splitting, OverlappingCloudsWithThingsBetween) {
    std::vector<test::BlobCloud> clouds{test::make_blob_cloud(40, 1, {0.3, 0.4, 0.866}, 2.0),
                                        test::make_blob_cloud(40, 2, {0.3, 0.4, 0.866}, 2.0)};
    const glm::dvec3 centres[] = {{-0.35, 4.0, 0.0}, {0.35, 4.8, 0.1}};
    test::BlobCloud both;
    std::vector<Sphere> volumes;
    for (std::size_t i = 0; i < 2; ++i) {
        for (test::Blob& blob : clouds[i].blobs) {
            blob.centre_m += centres[i];
            blob.key *= i == 0 ? 1.0F : 0.4F;
            both.blobs.push_back(blob);
        }
        clouds[i].bounds.centre_m = centres[i];
        volumes.push_back(clouds[i].bounds);
    }
    both.bounds = {{0, 4.4, 0}, 1.5};
    both.steps = 96;
    const std::vector<Disc> discs{{{{0.2, 4.4, 0.1}, 0.5}, {0.5F, 0.0F, 0.0F, 0.5F}},
                                  {{{-0.2, 4.0, -0.2}, 0.4}, {0.0F, 0.5F, 0.0F, 0.6F}},
                                  {{{0.3, 5.1, 0.0}, 0.5}, {0.0F, 0.0F, 0.9F, 0.9F}},
                                  {{{0.0, 2.0, 0.0}, 0.1}, {0.2F, 0.2F, 0.0F, 0.3F}},
                                  {{{0.0, 8.0, 0.0}, 2.0}, {0.3F, 0.0F, 0.3F, 1.0F}}};
    std::vector<Sphere> bounds;
    for (const Disc& d : discs) {
        bounds.push_back(d.bounds);
    }
    const std::size_t pixels = 72 * 72;
    std::vector<glm::vec4> exact(pixels, glm::vec4(0.0F));
    std::vector<glm::vec4> one(pixels);
    // Exact: slabs of the two clouds together, between the discs in their order.
    const double edges[] = {1e9, 8.0, 5.1, 4.4, 4.0, 2.0, 0.0};
    const std::size_t order[] = {4, 2, 0, 1, 3};
    for (std::size_t k = 0; k < 6; ++k) {
        CaptureRequest request;
        request.view = view;
        request.edges_m = {edges[k + 1], edges[k]};
        std::vector<SlabImage> slab(1);
        slab[0].colour.assign(pixels, glm::vec4(0.0F));
        slab[0].depth.assign(pixels, glm::vec2(0.0F));
        test::draw_blobs(both, request, slab);
        for (std::size_t i = 0; i < pixels; ++i) {
            slab[0].colour[i] += glm::vec4(slab[0].fill[i], 0.0F);
        }
        over(slab[0].colour, exact);
        if (k < 5) {
            draw_disc(discs[order[k]], one);
            over(one, exact);
        }
    }
    std::vector<Capture> pictures;
    for (const test::BlobCloud& cloud : clouds) {
        CaptureSettings settings;
        settings.layers = 16;
        pictures.push_back(std::move(capture(cloud.bounds, *fit_frustum(cloud.bounds, view.eye_m, {0, 0, 1}, 96),
                                             settings, test::drawable(cloud))
                                         .value()));
    }
    const auto show = [&](const SplitSettings& settings) {
        std::vector<glm::vec4> image(pixels, glm::vec4(0.0F));
        for (const OrderedItem& item : order_back_to_front(volumes, bounds, view, settings)) {
            std::fill(one.begin(), one.end(), glm::vec4(0.0F));
            if (item.object) {
                draw_disc(discs[item.index], one);
            } else {
                DrawSettings draw_settings;
                draw_settings.near_m = item.near_m;
                draw_settings.far_m = item.far_m;
                draw(pictures[item.index], view, draw_settings, one);
            }
            over(one, image);
        }
        return test::relative_rmse(image, exact);
    };
    const double unsplit = show({1, 1});
    const double split = show({16, 8});
    EXPECT_LT(split, 0.05);
    EXPECT_LT(split, 0.25 * unsplit);
    RecordProperty("relative_rmse", std::to_string(split));
    RecordProperty("relative_rmse_unsplit", std::to_string(unsplit));
}

TEST(Splitting, OnThePlaneAndManyObjects) {
    const Sphere cloud{{0, 10, 0}, 3.0};
    // Three at one depth, on the centre plane; one at the very front, one at the very back of the bounds.
    const Sphere objects[] = {
        {{0, 10, 0}, 0.1}, {{1, 10, 0}, 0.1}, {{-1, 10, 0}, 0.1}, {{0, 7, 0}, 0.1}, {{0, 13, 0}, 0.1}};
    const auto items = order_back_to_front({&cloud, 1}, objects, view);
    EXPECT_EQ(items.size(), 5U + 2U);
    EXPECT_TRUE(items.front().object && items.front().index == 4U);
    EXPECT_TRUE(items.back().object && items.back().index == 3U);
    // A hundred: no more pieces than allowed, everything drawn once.
    std::vector<Sphere> many;
    for (int k = 0; k < 100; ++k) {
        many.push_back({{0.0, 7.5 + 0.05 * k, 0.0}, 0.01});
    }
    const auto crowd = order_back_to_front({&cloud, 1}, many, view);
    EXPECT_EQ(std::count_if(crowd.begin(), crowd.end(), [](const OrderedItem& i) { return i.object; }), 100);
    EXPECT_LE(crowd.size(), 116U);
    double last = 1e9;
    for (const OrderedItem& item : crowd) {
        if (item.object) {
            EXPECT_LT(many[item.index].centre_m.y, last);
            last = many[item.index].centre_m.y;
        }
    }
}

} // namespace
} // namespace alpenglow::impostors
