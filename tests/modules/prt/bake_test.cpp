#include "helpers.hpp"

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/shapes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace alpenglow::prt {
namespace {

using test::distance;
using test::norm;
using test::rms;
using test::white;

std::vector<float> cosine(int order, const glm::vec3& normal) {
    std::vector<float> m(static_cast<std::size_t>(order * order));
    unshadowed(order, normal, m);
    return m;
}

double unoccluded_norm(int order) {
    return norm(cosine(order, {0.0F, 0.0F, 1.0F}));
}

BakeSettings quick() {
    BakeSettings settings;
    settings.order = 5;
    settings.rays = 1024;
    settings.gather_rays = 128;
    return settings;
}

// A ball over a plane: shadows with soft and hard parts.
Mesh ball_over_plane(int cells = 16) {
    return merged(plane(2.0F, cells), sphere(0.5F, 4), glm::vec3(0.1F, 0.2F, 0.8F));
}

TEST(Bake, UnshadowedIsTheCosineLobeInClosedForm) {
    // Against the integral, by quadrature in double.
    const glm::vec3 normal = glm::vec3(0.6F, -0.48F, 0.64F);
    constexpr int order = 6;
    std::vector<double> integral(36, 0.0);
    std::array<double, 36> y{};
    constexpr int steps = 400;
    for (int a = 0; a < steps; ++a) {
        for (int b = 0; b < 2 * steps; ++b) {
            const double z = -1.0 + 2.0 * (a + 0.5) / steps;
            const double phi = 3.14159265358979 * (b + 0.5) / steps;
            const double r = std::sqrt(1.0 - z * z);
            const glm::dvec3 d(r * std::cos(phi), r * std::sin(phi), z);
            const double c = d.x * 0.6 - d.y * 0.48 + d.z * 0.64;
            if (c <= 0.0) {
                continue;
            }
            sh::evaluate_basis(order, d, y);
            for (std::size_t i = 0; i < 36; ++i) {
                integral[i] += y[i] * c / 3.14159265358979 * 4.0 * 3.14159265358979 / (2.0 * steps * steps);
            }
        }
    }
    const std::vector<float> closed = cosine(order, normal);
    for (std::size_t i = 0; i < 36; ++i) {
        EXPECT_NEAR(closed[i], integral[i], 2e-5) << i;
    }
}

TEST(Bake, PlaneAndConvexBodyAreUnshadowed) {
    for (const Sampling sampling : {Sampling::random, Sampling::stratified, Sampling::fibonacci, Sampling::adaptive}) {
        for (const Mesh& mesh : {plane(3.0F, 5), sphere(2.0F, 5), box(glm::vec3(1.0F, 2.0F, 3.0F), 3)}) {
            BakeSettings settings = quick();
            settings.sampling = sampling;
            settings.rays = 256;
            const Result<Bake> baked = bake(mesh, settings);
            ASSERT_TRUE(baked) << baked.error().message();
            for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
                // Turning the vector from the point's frame costs a few last places.
                EXPECT_LT(distance(baked->field.point(i), cosine(5, mesh.normals[i])), 1e-6);
            }
            EXPECT_EQ(baked->report.inside_points, 0U);
            EXPECT_LT(baked->report.estimated_rms, 1e-9);
        }
    }
}

TEST(Bake, ClosedBoxSeenFromInsideIsExactlyDark) {
    const Mesh mesh = inverted(box(glm::vec3(1.0F), 4));
    for (const Transport transport : {Transport::shadowed, Transport::interreflected}) {
        BakeSettings settings = quick();
        settings.transport = transport;
        const Result<Bake> baked = bake(mesh, settings);
        ASSERT_TRUE(baked) << baked.error().message();
        EXPECT_TRUE(
            std::all_of(baked->field.values.begin(), baked->field.values.end(), [](float x) { return x == 0.0F; }));
        EXPECT_EQ(baked->report.dark_points, mesh.positions.size());
    }
}

TEST(Bake, ShadowHasTheAreaOfTheBallThatCastsIt) {
    // Response to white light under a sphere of radius r at height h above: 1 - form factor = 1 - (r / h)^2.
    Mesh mesh = merged(plane(0.02F, 2), sphere(0.5F, 24), glm::vec3(0.0F, 0.0F, 2.0F));
    BakeSettings settings = quick();
    settings.rays = 4096;
    settings.max_error = 0.0;
    const Result<Bake> baked = bake(mesh, settings);
    ASSERT_TRUE(baked);
    std::size_t centre = 4; // of the 3 x 3 plane
    ASSERT_EQ(mesh.positions[centre], glm::vec3(0.0F));
    EXPECT_NEAR(white(baked->field.point(centre)), 1.0 - 0.25 * 0.25, 2e-3);
}

TEST(Bake, SamplingsConvergeToOneAnswer) {
    const Mesh mesh = ball_over_plane(8);
    BakeSettings reference = quick();
    reference.sampling = Sampling::fibonacci;
    reference.rays = 16384;
    const Result<Bake> exact = bake(mesh, reference);
    ASSERT_TRUE(exact);
    for (const Sampling sampling : {Sampling::random, Sampling::stratified, Sampling::fibonacci, Sampling::adaptive}) {
        BakeSettings settings = quick();
        settings.sampling = sampling;
        settings.rays = 1024;
        settings.max_error = 0.0;
        const Result<Bake> baked = bake(mesh, settings);
        ASSERT_TRUE(baked);
        const double error = rms(baked->field, exact->field, unoccluded_norm(5));
        const double estimate = baked->report.estimated_rms;
        // The estimate is of the right size: within a factor of 2.5 (the reference has an error of its own).
        EXPECT_GT(estimate, error / 2.5) << static_cast<int>(sampling) << " error " << error;
        EXPECT_LT(estimate, error * 2.5) << static_cast<int>(sampling) << " error " << error;
        settings.rays = 4096;
        const Result<Bake> finer = bake(mesh, settings);
        ASSERT_TRUE(finer);
        EXPECT_LT(rms(finer->field, exact->field, unoccluded_norm(5)), 0.75 * error) << static_cast<int>(sampling);
    }
}

TEST(Bake, AdaptiveKeepsTheErrorThatItWasAskedFor) {
    const Mesh mesh = ball_over_plane(8);
    BakeSettings reference = quick();
    reference.sampling = Sampling::fibonacci;
    reference.rays = 32768;
    const Result<Bake> exact = bake(mesh, reference);
    ASSERT_TRUE(exact);
    std::uint64_t rays = 0;
    for (const double wanted : {0.04, 0.02, 0.01}) {
        BakeSettings settings = quick();
        settings.rays = 4096;
        settings.max_error = wanted;
        const Result<Bake> baked = bake(mesh, settings);
        ASSERT_TRUE(baked);
        EXPECT_LT(rms(baked->field, exact->field, unoccluded_norm(5)), wanted);
        EXPECT_GE(baked->report.shadow_rays, rays);
        rays = baked->report.shadow_rays;
    }
}

TEST(Bake, SameBitsForAnyThreadCount) {
    const Mesh mesh = ball_over_plane(10);
    BakeSettings settings = quick();
    settings.transport = Transport::interreflected;
    settings.threads = 1;
    const Result<Bake> one = bake(mesh, settings);
    ASSERT_TRUE(one);
    for (const unsigned threads : {2U, 5U}) {
        settings.threads = threads;
        const Result<Bake> many = bake(mesh, settings);
        ASSERT_TRUE(many);
        EXPECT_EQ(one->field.values, many->field.values);
    }
    settings.seed = 2;
    const Result<Bake> other = bake(mesh, settings);
    ASSERT_TRUE(other);
    EXPECT_NE(one->field.values, other->field.values);
}

TEST(Bake, WhiteFurnaceInABowl) {
    Mesh mesh = bowl(1.0F, 48, 16);
    mesh.albedo.assign(mesh.positions.size(), glm::vec3(1.0F));
    BakeSettings settings = quick();
    settings.transport = Transport::interreflected;
    settings.max_bounces = 200;
    settings.stop_energy = 1e-7;
    const Result<Bake> baked = bake(mesh, settings);
    ASSERT_TRUE(baked);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_NEAR(white(baked->field.point(i)), 1.0, 2e-4) << i;
    }
    EXPECT_NEAR(baked->report.furnace_mean, 1.0, 1e-4);
    EXPECT_NEAR(baked->report.furnace_worst, 1.0, 1e-3);
    // Energy falls from bounce to bounce.
    const std::vector<double>& energy = baked->report.bounce_energy;
    ASSERT_GT(energy.size(), 3U);
    for (std::size_t b = 1; b < energy.size(); ++b) {
        EXPECT_LT(energy[b], energy[b - 1]);
    }
}

TEST(Bake, BowlInterreflectionInClosedForm) {
    // An open half sphere of albedo a under white light: every point sees the opening with the same factor 1/2, and the
    // rest of the bowl uniformly, so radiosity over albedo is (1/2) / (1 - a/2), the same everywhere.
    Mesh mesh = bowl(1.0F, 64, 24);
    constexpr double albedo = 0.7;
    mesh.albedo.assign(mesh.positions.size(), glm::vec3(static_cast<float>(albedo)));
    BakeSettings settings = quick();
    settings.transport = Transport::interreflected;
    settings.stop_energy = 1e-6;
    settings.max_bounces = 100;
    settings.max_error = 1e-3;
    settings.rays = 4096;
    const Result<Bake> baked = bake(mesh, settings);
    ASSERT_TRUE(baked);
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        if (mesh.positions[i].z < -0.05F) { // the rim's normals see half of the facets edge-on
            sum += white(baked->field.point(i));
            ++count;
        }
    }
    EXPECT_NEAR(sum / static_cast<double>(count), 0.5 / (1.0 - albedo / 2.0), 0.01);
}

TEST(Bake, ColourBleeds) {
    Mesh mesh = bowl(1.0F, 24, 8);
    mesh.albedo.assign(mesh.positions.size(), glm::vec3(0.8F, 0.2F, 0.0F));
    BakeSettings settings = quick();
    settings.transport = Transport::interreflected;
    settings.colour = true;
    const Result<Bake> baked = bake(mesh, settings);
    ASSERT_TRUE(baked);
    ASSERT_EQ(baked->field.channels, 3);
    const std::span<const float> m = baked->field.point(0);
    EXPECT_GT(m[0], m[25] * 1.2F);
    EXPECT_GT(m[25], m[50]);
    settings.transport = Transport::shadowed;
    const Result<Bake> direct = bake(mesh, settings);
    ASSERT_TRUE(direct);
    EXPECT_EQ(m[50], direct->field.point(0)[0]); // a black channel gets no bounce
}

TEST(Bake, ShardsJoinToTheWholeBitForBit) {
    const Mesh mesh = ball_over_plane(9);
    BakeSettings settings = quick();
    settings.transport = Transport::interreflected;
    const Result<Bake> whole = bake(mesh, settings);
    ASSERT_TRUE(whole);
    std::vector<BakePart> parts;
    for (const std::size_t shard : {3U, 1U, 2U}) {
        const ShardRange range = shard_range(mesh.positions.size(), shard, 3);
        Result<BakePart> part = bake_part(mesh, settings, range.first, range.last - range.first);
        ASSERT_TRUE(part);
        parts.push_back(std::move(*part));
    }
    const Result<Bake> joined = finish(mesh, settings, parts);
    ASSERT_TRUE(joined) << joined.error().message();
    EXPECT_EQ(whole->field.values, joined->field.values);

    std::vector<BakePart> missing(parts.begin(), parts.begin() + 2);
    EXPECT_FALSE(finish(mesh, settings, missing));
    std::vector<BakePart> twice = parts;
    twice.push_back(parts.front());
    EXPECT_FALSE(finish(mesh, settings, twice));
    settings.rays = 2048;
    EXPECT_FALSE(finish(mesh, settings, parts));
}

TEST(Bake, LittleMemoryTracesAgainToTheSameBits) {
    const Mesh mesh = ball_over_plane(8);
    BakeSettings settings = quick();
    settings.transport = Transport::interreflected;
    const Result<Bake> roomy = bake(mesh, settings);
    settings.memory_bytes = 1024;
    const Result<Bake> tight = bake(mesh, settings);
    ASSERT_TRUE(roomy);
    ASSERT_TRUE(tight);
    EXPECT_TRUE(roomy->report.hits_kept);
    EXPECT_FALSE(tight->report.hits_kept);
    EXPECT_EQ(roomy->field.values, tight->field.values);
}

TEST(Bake, ProgressRisesAndCancelEndsIt) {
    const Mesh mesh = sphere(1.0F, 12);
    BakeSettings settings = quick();
    settings.sampling = Sampling::fibonacci;
    double last = 0.0;
    bool rises = true;
    settings.progress = [&](const Progress& p) {
        rises = rises && p.fraction >= last && p.fraction <= 1.0;
        last = p.fraction;
        return true;
    };
    ASSERT_TRUE(bake(mesh, settings));
    EXPECT_TRUE(rises);
    settings.rays = 1U << 18U; // would take minutes
    settings.progress = [](const Progress&) { return false; };
    const Result<Bake> cancelled = bake(mesh, settings);
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(cancelled.error().what, "cancelled");
}

TEST(Bake, MirrorSendsLightOn) {
    // A mirror wall beside a floor doubles the sky for the floor next to it: the response to white light is that of the
    // floor without a wall.
    Mesh floor = plane(1.0F, 8);
    Mesh wall = plane(40.0F, 2);
    for (glm::vec3& p : wall.positions) {
        p = {p.z + 1.05F, p.x, p.y}; // x = 1.05, facing +X
    }
    wall.normals.clear();
    compute_normals(wall);
    for (glm::uvec3& t : wall.triangles) {
        std::swap(t.y, t.z); // face the floor
    }
    compute_normals(wall);
    wall.mirror.assign(wall.triangles.size(), 1);
    const Mesh mesh = merged(floor, wall);
    BakeSettings settings = quick();
    settings.rays = 4096;
    const Result<Bake> baked = bake(mesh, settings);
    ASSERT_TRUE(baked) << baked.error().message();
    for (std::size_t i = 0; i < floor.positions.size(); ++i) {
        // What the mirror shows of the sky comes back; a ray off it that falls on the floor again does not.
        EXPECT_NEAR(white(baked->field.point(i)), 1.0, 0.02) << floor.positions[i].x;
        // Light from -x side is doubled: the x coefficient doubles or stays.
        EXPECT_GE(std::abs(baked->field.point(i)[3]), -1e-4F);
    }
    for (std::size_t i = floor.positions.size(); i < mesh.positions.size(); ++i) {
        EXPECT_EQ(norm(baked->field.point(i)), 0.0); // no transfer is recorded on mirrors
    }
}

TEST(Bake, TexelsAgreeWithVertices) {
    const Mesh mesh = ball_over_plane(8);
    BakeSettings settings = quick();
    settings.transport = Transport::interreflected;
    settings.max_error = 5e-3;
    settings.rays = 4096;
    const Result<Bake> vertices = bake(mesh, settings);
    BakePoints points{mesh.positions, mesh.normals};
    const Result<Bake> texels = bake_points(mesh, points, settings);
    ASSERT_TRUE(vertices);
    ASSERT_TRUE(texels) << texels.error().message();
    EXPECT_EQ(texels->field.kind, TransferKind::texels);
    EXPECT_LT(rms(vertices->field, texels->field, unoccluded_norm(5)), 0.02);
}

TEST(Bake, RefusesWhatCannotBeBaked) {
    const BakeSettings settings = quick();
    EXPECT_FALSE(bake(Mesh{}, settings));
    Mesh mesh = plane(1.0F, 2);
    mesh.positions[3].y = std::numeric_limits<float>::quiet_NaN();
    const Result<Bake> nan = bake(mesh, settings);
    ASSERT_FALSE(nan);
    EXPECT_NE(nan.error().message().find("vertex 3"), std::string::npos) << nan.error().message();
    mesh = plane(1.0F, 2);
    mesh.triangles[1].z = 99;
    const Result<Bake> index = bake(mesh, settings);
    ASSERT_FALSE(index);
    EXPECT_NE(index.error().message().find("triangle 1"), std::string::npos);
    mesh = plane(1.0F, 2);
    for (glm::uvec3& t : mesh.triangles) {
        t.z = t.y;
    }
    EXPECT_FALSE(bake(mesh, settings)); // nothing but degenerate triangles
    mesh = plane(1.0F, 2);
    mesh.albedo.assign(mesh.positions.size(), glm::vec3(1.5F));
    EXPECT_FALSE(bake(mesh, settings));
    mesh = plane(1.0F, 2);
    BakeSettings absurd = settings;
    absurd.order = 7;
    EXPECT_FALSE(bake(mesh, absurd));
    absurd = settings;
    absurd.rays = 0;
    EXPECT_FALSE(bake(mesh, absurd));
    // Winding inwards, normals inwards wrong: every vertex looks at backs.
    Mesh inside_out = sphere(1.0F, 4);
    for (glm::vec3& n : inside_out.normals) {
        n = -n;
    }
    const Result<Bake> inside = bake(inside_out, settings);
    ASSERT_FALSE(inside);
    EXPECT_NE(inside.error().message().find("inside"), std::string::npos);
}

TEST(Bake, ReportsWhatItFound) {
    Mesh mesh = plane(1.0F, 4);
    mesh.positions.emplace_back(5.0F, 5.0F, 5.0F); // isolated
    mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
    mesh.triangles.emplace_back(0, 0, 1); // degenerate
    mesh.normals[2] = glm::vec3(0.0F);
    const Result<Bake> baked = bake(mesh, quick());
    ASSERT_TRUE(baked);
    EXPECT_EQ(baked->report.mesh.isolated_vertices, 1U);
    EXPECT_EQ(baked->report.mesh.degenerate_triangles, 1U);
    EXPECT_EQ(baked->report.mesh.bad_normals, 1U);
    EXPECT_EQ(norm(baked->field.point(mesh.positions.size() - 1)), 0.0);
    EXPECT_LT(distance(baked->field.point(2), cosine(5, {0.0F, 0.0F, 1.0F})), 1e-6); // mended
    EXPECT_NE(baked->report.text().find("isolated vertices      1"), std::string::npos);
}

} // namespace
} // namespace alpenglow::prt
