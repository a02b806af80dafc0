#include "sandbox/render/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <imgui.h>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <alpenglow/sh/image.hpp>

#include "gpu_test.hpp"
#include "sandbox/render/sky_dome.hpp"
#include "sandbox/world/overlay_render_data.hpp"
#include "sandbox/world/vertex.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr VkExtent2D kExtent{320, 180};
constexpr glm::vec3 kUp(0.0F, 0.0F, 1.0F);

// shaders/passes/tone.glsl in double precision: 0 .. 1.
glm::dvec3 display(glm::dvec3 radiance) {
    const double brightest = std::clamp(std::max({radiance.x, radiance.y, radiance.z}), 1e-6, 1e4);
    const double curve =
        std::min(brightest * (brightest + 0.26093) / (brightest * (0.99189 * brightest + 0.37611) + 0.061396), 1.0);
    glm::dvec3 r = radiance / brightest;
    r += 0.8 * brightest / (brightest + 8.0) * (1.0 - r);
    return curve * glm::sqrt(r) * (1.0 + 0.14 * (1.0 - r) * (1.0 - r));
}

// A flat plain of 33 x 33 vertices, and squares of 4 m that stand on it, facing south.
struct Plain {
    WorldData world;
    std::vector<std::uint32_t> indices;

    explicit Plain(glm::vec3 albedo = glm::vec3(0.2F, 0.25F, 0.15F), float spacing = 60.0F) {
        constexpr std::uint32_t n = 33;
        const float origin = -0.5F * spacing * static_cast<float>(n - 1);
        for (std::uint32_t j = 0; j < n; ++j) {
            for (std::uint32_t i = 0; i < n; ++i) {
                Vertex vertex{};
                vertex.position_m = {origin + spacing * static_cast<float>(i), origin + spacing * static_cast<float>(j),
                                     0.0F};
                vertex.normal = pack_normal(kUp);
                vertex.albedo = pack_albedo(albedo, 1.0F);
                world.terrain.vertices.push_back(vertex);
            }
        }
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            for (std::uint32_t i = 0; i + 1 < n; ++i) {
                const std::uint32_t v = j * n + i;
                indices.insert(indices.end(), {v, v + 1, v + n, v + 1, v + n + 1, v + n});
            }
        }
        world.terrain_grids = {{0, n, spacing, {origin, origin}}};
        MeshData square;
        for (const glm::vec3 corner :
             {glm::vec3(-2, 0, 0), glm::vec3(2, 0, 0), glm::vec3(2, 0, 4), glm::vec3(-2, 0, 4)}) {
            Vertex vertex{};
            vertex.position_m = corner;
            vertex.normal = pack_normal({0.0F, -1.0F, 0.0F});
            vertex.albedo = pack_albedo(glm::vec3(0.36F, 0.25F, 0.16F), 1.0F);
            square.vertices.push_back(vertex);
        }
        square.indices = {0, 1, 2, 0, 2, 3};
        world.object_meshes = {square};
    }

    void add_square(glm::vec3 at, std::array<std::uint32_t, 4> horizon = {}) {
        ObjectInstance object;
        object.world_from_object = glm::translate(glm::mat4(1.0F), at);
        object.horizon = horizon;
        world.objects.push_back(object);
    }
};

class RendererTest : public vulkan::GpuTest, public testing::WithParamInterface<Quality> {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        // 20 m south of the origin, 2 m up, looking north.
        frame.camera_m = {0.0F, -20.0F, 2.0F};
        look({0.0F, 1.0F, 0.0F});
        frame.exposure = 5e-5F;
        frame.to_sun = glm::normalize(glm::vec3(0.3F, -0.8F, 0.5F));
        frame.sun_illuminance_lux = {60000.0F, 55000.0F, 45000.0F};
        for (std::size_t channel = 0; channel < 3; ++channel) {
            frame.irradiance_matrix[channel][3][3] = 6000.0F + 3000.0F * static_cast<float>(channel); // constant
        }
        frame.rayleigh_per_m = glm::vec3(0.0F); // no air, unless a test is about air
        frame.mie_per_m = glm::vec3(0.0F);
        set_sky(glm::vec3(3000.0F, 5000.0F, 9000.0F));
    }
    void TearDown() override {
        renderer.reset();
        GpuTest::TearDown();
    }

    void look(glm::vec3 along) {
        frame.view = glm::lookAtRH(frame.camera_m, frame.camera_m + along, kUp);
        frame.projection = glm::perspectiveRH_ZO(0.8F, 320.0F / 180.0F, 0.5F, 50000.0F);
        frame.projection[1][1] *= -1.0F;
    }

    void set_sky(glm::vec3 radiance) {
        sky.resize(SkyDome::vertices);
        place_sky_vertices(frame.to_sun, 0.0F, sky);
        for (SkyVertex& vertex : sky) {
            vertex.radiance_cd_m2 = radiance;
        }
        frame.sky_vertices = sky;
        ++frame.sky_revision;
    }

    void start(const Plain& plain) {
        frame.terrain_indices = plain.indices;
        ++frame.terrain_indices_revision;
        Result<std::unique_ptr<Renderer>> made =
            Renderer::create(*device, plain.world, {.extent = kExtent, .quality = GetParam()});
        ASSERT_TRUE(made) << made.error().message();
        renderer = std::move(made).value();
        ASSERT_EQ(renderer->quality(), GetParam());
    }

    DrawStats draw(ImDrawData* hud = nullptr) {
        const Result<DrawStats> stats = renderer->draw(frame, nullptr, hud);
        EXPECT_TRUE(stats) << (stats ? "" : stats.error().message());
        Result<std::vector<std::byte>> read = renderer->read_pixels();
        EXPECT_TRUE(read);
        pixels = std::move(read).value();
        return stats ? *stats : DrawStats{};
    }

    [[nodiscard]] std::array<int, 3> pixel(std::uint32_t x, std::uint32_t y) const {
        const std::size_t at = 4 * (std::size_t{y} * renderer->extent().width + x);
        return {std::to_integer<int>(pixels[at]), std::to_integer<int>(pixels[at + 1]),
                std::to_integer<int>(pixels[at + 2])};
    }

    // Mean of a rectangle of pixels, 0 .. 255.
    [[nodiscard]] glm::dvec3 mean(std::uint32_t left, std::uint32_t top, std::uint32_t right,
                                  std::uint32_t bottom) const {
        glm::dvec3 sum(0.0);
        for (std::uint32_t y = top; y < bottom; ++y) {
            for (std::uint32_t x = left; x < right; ++x) {
                const std::array<int, 3> p = pixel(x, y);
                sum += glm::dvec3(p[0], p[1], p[2]);
            }
        }
        return sum / double(std::size_t{right - left} * (bottom - top));
    }

    // What a surface of that albedo and normal shows.
    [[nodiscard]] glm::dvec3 lit(glm::vec3 albedo, glm::vec3 normal, float sun_share) const {
        glm::dvec3 radiance{};
        for (int k = 0; k < 3; ++k) {
            const double sky_lux = frame.irradiance_matrix[static_cast<std::size_t>(k)][3][3];
            const double sun_lux =
                sun_share * frame.sun_illuminance_lux[k] * std::max(glm::dot(normal, frame.to_sun), 0.0F);
            radiance[k] = albedo[k] / std::numbers::pi * (sky_lux + sun_lux) * frame.exposure;
        }
        return 255.0 * display(radiance);
    }

    void expect_near(glm::dvec3 a, glm::dvec3 b, double tolerance) const {
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(a[k], b[k], tolerance) << "channel " << k;
        }
    }

    FrameData frame;
    std::vector<SkyVertex> sky;
    std::unique_ptr<Renderer> renderer;
    std::vector<std::byte> pixels;
};

const glm::vec3 kSquareAlbedo(0.36F, 0.25F, 0.16F);
const glm::vec3 kSouth(0.0F, -1.0F, 0.0F);

TEST_P(RendererTest, ObjectShowsLambertsReflection) {
    Plain plain;
    plain.add_square({0.0F, 0.0F, 0.0F});
    start(plain);
    draw();
    expect_near(mean(150, 80, 170, 100), lit(kSquareAlbedo, kSouth, 1.0F), 1.5); // 8 bits of albedo, dither
}

TEST_P(RendererTest, HorizonAboveTheSunLeavesTheSkysLight) {
    Plain plain;
    plain.add_square({0.0F, 0.0F, 0.0F}, {~0U, ~0U, ~0U, ~0U});
    start(plain);
    draw();
    expect_near(mean(150, 80, 170, 100), lit(kSquareAlbedo, kSouth, 0.0F), 1.5);
}

// The sun's centre on the horizon: half its light.
TEST_P(RendererTest, PenumbraIsTheVisiblePartOfTheDisc) {
    Plain plain;
    const float root = 100.0F / 255.0F;
    const float elevation = 0.5F * kPi * root * root;
    frame.to_sun = {0.0F, -std::cos(elevation), std::sin(elevation)};
    set_sky(glm::vec3(5000.0F));
    plain.add_square({0.0F, 0.0F, 0.0F}, {0x64646464U, 0x64646464U, 0x64646464U, 0x64646464U}); // 100 everywhere
    start(plain);
    draw();
    expect_near(mean(150, 80, 170, 100), lit(kSquareAlbedo, kSouth, 0.5F), 2.0);
}

// The ground's detail varies its light, by design around a mean of 1: over whole tiles of it the mean radiance, that
// is before the tone curve, is the plain's.
TEST_P(RendererTest, GroundHasOnAverageTheTerrainsLight) {
    const glm::vec3 albedo(0.25F);
    frame.sun_illuminance_lux = glm::vec3(55000.0F);
    for (glm::mat4& irradiance : frame.irradiance_matrix) {
        irradiance[3][3] = 8000.0F;
    }
    const Plain plain(albedo, 900.0F);
    start(plain);
    // From above, the picture 20 tiles of the larger size high.
    const float side = 20.0F * kDetailTiles.back();
    frame.camera_m = {0.0F, 0.0F, 0.5F * side / std::tan(0.4F)};
    look({0.0F, 1e-4F, -1.0F});
    draw();
    // Grey is undone by inverting the curve.
    std::array<double, 256> radiance{}; // by shown byte
    double x = 0.0;
    for (std::size_t byte = 0; byte < 256; ++byte) {
        while (255.0 * display(glm::dvec3(x)).x < static_cast<double>(byte) && x < 100.0) {
            x += 1e-4;
        }
        radiance[byte] = x;
    }
    double sum = 0.0;
    int count = 0;
    for (std::uint32_t row = 0; row < 180; ++row) {
        for (std::uint32_t column = 70; column < 250; ++column) {
            sum += radiance[static_cast<std::size_t>(pixel(column, row)[1])];
            ++count;
        }
    }
    const double expected = radiance[static_cast<std::size_t>(std::lround(lit(albedo, kUp, 1.0F).y))];
    EXPECT_NEAR(sum / count / expected, 1.0, 0.04);
}

TEST_P(RendererTest, SkyShowsItsRadiance) {
    const Plain plain;
    start(plain);
    draw();
    const glm::dvec3 radiance(3000.0, 5000.0, 9000.0);
    expect_near(mean(0, 0, 320, 40), 255.0 * display(radiance * double{frame.exposure}), 1.0);
}

// Far away, whatever stands there has the horizon's light.
TEST_P(RendererTest, AirHidesWhatIsFar) {
    Plain plain;
    plain.add_square({0.0F, 0.0F, 0.0F});
    start(plain);
    frame.mie_per_m = glm::vec3(1.0F); // 20 m are 20 optical depths
    frame.mie_height_m = 1e9F;
    draw();
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(mean(150, 80, 170, 100)[k], mean(0, 0, 320, 20)[k], 1.5);
    }
}

TEST_P(RendererTest, NearerHidesFartherWhateverTheOrder) {
    for (const bool near_first : {true, false}) {
        Plain plain;
        plain.add_square({0.0F, near_first ? 0.0F : 6.0F, 0.0F},
                         near_first ? std::array<std::uint32_t, 4>{}
                                    : std::array<std::uint32_t, 4>{~0U, ~0U, ~0U, ~0U});
        plain.add_square({0.0F, near_first ? 6.0F : 0.0F, 0.0F}, near_first
                                                                     ? std::array<std::uint32_t, 4>{~0U, ~0U, ~0U, ~0U}
                                                                     : std::array<std::uint32_t, 4>{});
        start(plain);
        draw();
        expect_near(mean(155, 80, 165, 90), lit(kSquareAlbedo, kSouth, 1.0F), 1.5);
    }
}

TEST_P(RendererTest, StaticSceneUploadsNothingAndDrawsTheSameBytes) {
    Plain plain;
    plain.add_square({0.0F, 0.0F, 0.0F});
    start(plain);
    EXPECT_GT(draw().uploads, 0U);
    const std::vector<std::byte> first = pixels;
    for (int i = 0; i < 3; ++i) {
        const DrawStats stats = draw();
        EXPECT_EQ(stats.uploads, 0U);
        EXPECT_EQ(stats.upload_bytes, 0U);
        EXPECT_EQ(pixels, first);
    }
    // And a second renderer draws them too.
    start(plain);
    draw();
    EXPECT_EQ(pixels, first);
}

TEST_P(RendererTest, ChangesReachThePicture) {
    Plain plain;
    start(plain);
    draw();
    const std::vector<std::byte> first = pixels;
    set_sky(glm::vec3(9000.0F, 2000.0F, 2000.0F));
    EXPECT_EQ(draw().uploads, 1U);
    EXPECT_NE(pixels, first);
    EXPECT_GT(mean(0, 0, 320, 40).x, mean(0, 0, 320, 40).z);
}

TEST_P(RendererTest, ResizesAndRefusesAbsurdSizes) {
    const Plain plain;
    start(plain);
    draw();
    ASSERT_TRUE(renderer->resize({200, 100}));
    draw();
    EXPECT_EQ(pixels.size(), std::size_t{4} * 200 * 100);
    const Status refused = renderer->resize({100000, 100000});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message().find("100000x100000"), std::string::npos);
    draw(); // as before
    EXPECT_EQ(pixels.size(), std::size_t{4} * 200 * 100);
}

TEST_P(RendererTest, MoonsLitSideFacesTheSun) {
    const Plain plain;
    start(plain);
    look({0.0F, 1.0F, 0.6F});
    frame.to_moon = glm::normalize(glm::vec3(0.0F, 1.0F, 0.6F));
    frame.moon_illuminance_lux = glm::vec3(0.05F);
    frame.moon_angular_radius_rad = 0.1F; // large, to see its phase
    frame.sun_illuminance_lux = glm::vec3(0.0F);
    set_sky(glm::vec3(0.01F));
    frame.exposure = 50.0F;
    for (const float side : {-1.0F, 1.0F}) {
        frame.to_sun = {side, 0.0F, 0.0F};
        draw();
        const double left = mean(145, 80, 158, 100).y;
        const double right = mean(162, 80, 175, 100).y;
        EXPECT_GT(side * (right - left), 20.0);
        // The dark side is the sky.
        const double dark = side > 0.0F ? mean(145, 85, 150, 95).y : mean(170, 85, 175, 95).y;
        EXPECT_NEAR(dark, mean(0, 0, 40, 20).y, 1.0);
    }
}

TEST_P(RendererTest, SunsDiscStandsWhereTheSunIs) {
    const Plain plain;
    start(plain);
    look({0.0F, 1.0F, 0.4F});
    frame.to_sun = glm::normalize(glm::vec3(0.0F, 1.0F, 0.4F));
    frame.sun_angular_radius_rad = 0.03F;
    set_sky(glm::vec3(500.0F));
    draw();
    EXPECT_GT(mean(158, 88, 162, 92).x, 250.0);
    // Radius in pixels: 90 / tan(0.4) * tan(0.03).
    const double radius = 90.0 / std::tan(0.4) * std::tan(0.03);
    int across = 0;
    for (std::uint32_t x = 0; x < 320; ++x) {
        across += pixel(x, 90)[0] > 200 ? 1 : 0;
    }
    EXPECT_NEAR(across, 2.0 * radius, 2.0);
}

TEST_P(RendererTest, HudLiesOverItsRectanglesAloneAndIsKept) {
    const Plain plain;
    start(plain);
    draw();
    const std::vector<std::byte> without = pixels;

    ImGuiContext* context = ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::GetIO().DisplaySize = {320.0F, 180.0F};
    ASSERT_TRUE(renderer->enable_hud(*instance));
    const auto show = [&](const char* text) -> ImDrawData* {
        ImGui::NewFrame();
        ImGui::SetNextWindowPos({20.0F, 30.0F});
        ImGui::SetNextWindowSize({100.0F, 60.0F});
        ImGui::Begin("w", nullptr, ImGuiWindowFlags_NoDecoration);
        ImGui::TextUnformatted(text);
        ImGui::End();
        ImGui::Render();
        return ImGui::GetDrawData();
    };
    show("60 fps"); // a window takes its size in its second frame
    EXPECT_TRUE(draw(show("60 fps")).hud_redrawn);
    const std::vector<std::byte> with = pixels;
    int changed = 0;
    for (std::uint32_t y = 0; y < kExtent.height; ++y) {
        for (std::uint32_t x = 0; x < kExtent.width; ++x) {
            const std::size_t at = 4 * (std::size_t{y} * kExtent.width + x);
            const bool same = std::equal(with.begin() + static_cast<std::ptrdiff_t>(at),
                                         with.begin() + static_cast<std::ptrdiff_t>(at + 4),
                                         without.begin() + static_cast<std::ptrdiff_t>(at));
            const bool inside = x >= 18 && x < 122 && y >= 28 && y < 92;
            ASSERT_TRUE(same || inside) << x << ", " << y;
            changed += same ? 0 : 1;
        }
    }
    EXPECT_GT(changed, 3000);
    EXPECT_FALSE(draw(show("60 fps")).hud_redrawn);
    EXPECT_EQ(pixels, with);
    EXPECT_TRUE(draw(show("59 fps")).hud_redrawn);
    EXPECT_NE(pixels, with);
    ASSERT_TRUE(renderer->resize({200, 100}));
    draw(show("59 fps"));
    renderer.reset();
    ImGui::DestroyContext(context);
}

// A picture over the frame: each of its pixels in its place as it is, nothing else touched, uploaded once a revision.
TEST_P(RendererTest, AnOverlayLiesPixelByPixel) {
    const Plain plain;
    start(plain);
    draw();
    const std::vector<std::byte> without = pixels;
    constexpr int width = 9;
    constexpr int height = 5;
    std::vector<std::byte> rgba;
    for (int i = 0; i < width * height; ++i) {
        for (const int value : {3 * i, 255 - i, i, 255}) {
            rgba.push_back(static_cast<std::byte>(value));
        }
    }
    const OverlayRenderData overlay{
        .rgba = rgba, .width = width, .height = height, .left = 17, .top = 101, .revision = next_revision()};
    frame.overlay = &overlay;
    EXPECT_EQ(draw().uploads, 1U);
    for (std::uint32_t y = 0; y < kExtent.height; ++y) {
        for (std::uint32_t x = 0; x < kExtent.width; ++x) {
            const std::size_t at = 4 * (std::size_t{y} * kExtent.width + x);
            const bool inside = x >= 17 && x < 17 + width && y >= 101 && y < 101 + height;
            const std::size_t i = inside ? (y - 101) * width + (x - 17) : 0;
            for (std::size_t c = 0; c < 3; ++c) {
                ASSERT_EQ(pixels[at + c], inside ? rgba[4 * i + c] : without[at + c]) << x << ' ' << y;
            }
        }
    }
    EXPECT_EQ(draw().uploads, 0U);
    frame.overlay = nullptr;
    draw();
    EXPECT_EQ(pixels, without);
}

INSTANTIATE_TEST_SUITE_P(Qualities, RendererTest, testing::Values(Quality::lean, Quality::full),
                         [](const testing::TestParamInfo<Quality>& parameter) {
                             return parameter.param == Quality::lean ? "lean" : "full";
                         });

class DecalTest : public RendererTest {};

// A decal takes away the sun's light; in the terrain's shadow it takes nothing.
TEST_P(DecalTest, TakesAwayTheSunsLight) {
    const glm::vec3 albedo(0.15F);
    const Plain plain(albedo);
    start(plain);
    draw();
    const glm::dvec3 open = mean(120, 130, 200, 170);
    std::vector<ShadowVertex> vertices{{{-30.0F, -30.0F, 0.01F}, 1.0F},
                                       {{30.0F, -30.0F, 0.01F}, 1.0F},
                                       {{30.0F, 30.0F, 0.01F}, 1.0F},
                                       {{-30.0F, 30.0F, 0.01F}, 1.0F}};
    const std::vector<std::uint32_t> indices{0, 1, 2, 0, 2, 3};
    frame.shadow_vertices = vertices;
    frame.shadow_indices = indices;
    ++frame.shadow_revision;
    draw();
    const glm::dvec3 shaded = mean(120, 130, 200, 170);
    const glm::dvec3 factor = lit(albedo, kUp, 0.0F) / lit(albedo, kUp, 1.0F);
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(shaded[k] / open[k], factor[k], 0.02);
    }
    for (ShadowVertex& vertex : vertices) {
        vertex.horizon = {~0U, ~0U, ~0U, ~0U};
    }
    ++frame.shadow_revision;
    draw();
    expect_near(mean(120, 130, 200, 170), open, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Lean, DecalTest, testing::Values(Quality::lean));

class ShadowTest : public RendererTest {};

// A square throws its shadow on the ground behind it, away from the sun.
TEST_P(ShadowTest, ObjectsShadeTheGround) {
    Plain plain;
    start(plain);
    frame.camera_m = {0.0F, 0.0F, 40.0F};
    frame.view = glm::lookAtRH(frame.camera_m, glm::vec3(0.0F), glm::vec3(0.0F, 1.0F, 0.0F)); // north is up
    frame.to_sun = glm::normalize(glm::vec3(0.0F, -1.0F, 1.0F));                              // south, 45 degrees
    draw();
    const glm::dvec3 open = mean(157, 55, 163, 63); // 5 to 7 m north of the middle
    plain.add_square({0.0F, 4.0F, 0.0F});           // shadow on y = 4 .. 8
    start(plain);
    draw();
    EXPECT_LT(mean(157, 55, 163, 63).y, 0.7 * open.y);
    EXPECT_GT(mean(157, 74, 163, 78).y, 0.7 * open.y); // in front of it
}

// Every face of a capture shows the radiance of the direction that its texel stands for, sky above and ground below.
TEST_P(RendererTest, CapturesAreRadianceByDirection) {
    Plain plain;
    start(plain);
    frame.sun_illuminance_lux = glm::vec3(0.0F);
    frame.moon_illuminance_lux = glm::vec3(0.0F);
    const auto radiance = [](const glm::vec3& d) { return 1000.0F * (glm::vec3(2.0F) + glm::vec3(d.x, d.y, d.z)); };
    place_sky_vertices(frame.to_sun, 0.0F, sky);
    for (SkyVertex& vertex : sky) {
        vertex.radiance_cd_m2 = radiance(vertex.direction);
    }
    ++frame.sky_revision;
    std::vector<glm::vec3> texels(std::size_t{capture_edge} * capture_edge);
    for (int face = 0; face < 6; ++face) {
        const Status captured = renderer->capture(frame, glm::vec3(0.0F, 0.0F, 5.0F), face, texels);
        ASSERT_TRUE(captured) << captured.error().message();
        int above = 0;
        for (int row = 0; row < capture_edge; ++row) {
            for (int column = 0; column < capture_edge; ++column) {
                const auto centre = [](int i) { return (2.0 * i + 1.0) / capture_edge - 1.0; };
                const glm::vec3 d = glm::normalize(glm::vec3(sh::cube_direction(face, centre(column), centre(row))));
                if (d.z > 0.05F) {
                    const glm::vec3 seen = texels[static_cast<std::size_t>(row * capture_edge + column)];
                    for (int k = 0; k < 3; ++k) {
                        ASSERT_NEAR(seen[k], radiance(d)[k], 30.0F) << face << ' ' << row << ' ' << column;
                    }
                    ++above;
                }
            }
        }
        EXPECT_GE(above, face == 5 ? 0 : face == 4 ? capture_edge * capture_edge : 400);
    }
}

INSTANTIATE_TEST_SUITE_P(Full, ShadowTest, testing::Values(Quality::full));

} // namespace
} // namespace alpenglow::sandbox
