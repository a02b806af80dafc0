// alpenglow-cloud-reference: unbiased pictures of clouds, on one machine or on many.
#include "study.hpp"

#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/clouds/reference.hpp>
#include <alpenglow/clouds/vdb.hpp>
#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace {

using namespace alpenglow;
using namespace alpenglow::clouds;

int fail(const Error& error) {
    std::fprintf(stderr, "alpenglow-cloud-reference: %s\n", error.message().c_str());
    return 1;
}

struct RenderOptions {
    std::string vdb, grid, output;
    unsigned seed = 1;
    double extinction = 1.0, albedo = 0.99, g = 0.85, g2 = -0.3, weight = 0.85;
    std::string phase = "hg";
    std::array<double, 2> sun{180.0, 30.0};
    double sun_radius = 0.0;
    std::array<double, 3> irradiance{1.0, 1.0, 1.0}, sky{0.0, 0.0, 0.0}, ground{0.0, 0.0, 0.0};
    double ground_height = 0.0;
    bool no_sun = false, with_ground = false, fresh = false;
    std::array<double, 2> view{0.0, 0.0};
    double distance = 0.0, tangent = 0.3;
    int width = 160, height = 90;
    std::uint64_t samples = 256, every = 16;
    std::string shard = "0/1";
};

glm::dvec3 direction(const std::array<double, 2>& azimuth_elevation) {
    const double a = azimuth_elevation[0] * degree_rad;
    const double e = azimuth_elevation[1] * degree_rad;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

// What a picture was made from: a resumed or merged one must agree in all but the shard.
std::string note_of(const RenderOptions& o) {
    std::ostringstream note;
    note << "cloud " << (o.vdb.empty() ? "study " + std::to_string(o.seed) : o.vdb + ":" + o.grid) << " extinction "
         << o.extinction << " albedo " << o.albedo << " phase " << o.phase << " " << o.g << " " << o.g2 << " "
         << o.weight << " sun " << (o.no_sun ? 0 : 1) << " " << o.sun[0] << " " << o.sun[1] << " " << o.sun_radius
         << " irradiance " << o.irradiance[0] << " " << o.irradiance[1] << " " << o.irradiance[2] << " sky " << o.sky[0]
         << " " << o.sky[1] << " " << o.sky[2] << " ground " << (o.with_ground ? 1 : 0) << " " << o.ground_height << " "
         << o.ground[0] << " " << o.ground[1] << " " << o.ground[2] << " view " << o.view[0] << " " << o.view[1] << " "
         << o.distance << " " << o.tangent;
    return note.str();
}

int render(const RenderOptions& o) {
    unsigned shard = 0;
    unsigned shards = 1;
    if (std::sscanf(o.shard.c_str(), "%u/%u", &shard, &shards) != 2 || shards == 0 || shard >= shards) {
        return fail({"'" + o.shard + "'", "--shard", "k/n with 0 <= k < n"});
    }
    SparseGrid grid;
    if (o.vdb.empty()) {
        grid = cumulus_of_study(o.seed);
    } else {
        auto loaded = load_vdb(o.vdb, o.grid);
        if (!loaded) {
            return fail(loaded.error());
        }
        auto sparse = sparse_from_vdb(*loaded, o.vdb + ": " + loaded->name());
        if (!sparse) {
            return fail(sparse.error());
        }
        grid = std::move(*sparse);
    }
    Phase phase{PhaseKind::henyey_greenstein, static_cast<float>(o.g), static_cast<float>(o.g2),
                static_cast<float>(o.weight)};
    if (o.phase == "double-hg") {
        phase.kind = PhaseKind::double_henyey_greenstein;
    } else if (o.phase == "cornette-shanks") {
        phase.kind = PhaseKind::cornette_shanks;
    } else if (o.phase == "rayleigh") {
        phase.kind = PhaseKind::rayleigh;
    }
    ReferenceScene scene;
    scene.grid = &grid;
    scene.medium = {static_cast<float>(o.extinction), static_cast<float>(o.albedo), phase};
    if (!o.no_sun) {
        scene.lights.push_back({glm::vec3(direction(o.sun)),
                                glm::vec3(o.irradiance[0], o.irradiance[1], o.irradiance[2]),
                                static_cast<float>(o.sun_radius * degree_rad)});
    }
    const glm::vec3 sky(o.sky[0], o.sky[1], o.sky[2]);
    scene.sky = [sky](const glm::vec3&) { return sky; };
    scene.ground = {o.with_ground, o.ground_height, glm::vec3(o.ground[0], o.ground[1], o.ground[2])};

    glm::dvec3 low(1e30);
    glm::dvec3 high(-1e30);
    for (const glm::ivec3& c : grid.table().coordinates()) {
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 index = grid.min() + c * 8 + glm::ivec3(corner & 1, (corner >> 1) & 1, corner >> 2) * 8;
            const glm::dvec3 p = grid.transform().world_from_index(glm::dvec3(index));
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
        }
    }
    if (low.x > high.x) {
        return fail({"the cloud is empty", o.vdb, "a grid with densities above 0"});
    }
    const glm::dvec3 centre = (low + high) * 0.5;
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    const double distance = o.distance > 0.0 ? o.distance : 1.7 * extent;
    const Camera camera =
        look_at(centre + direction(o.view) * distance, centre, static_cast<float>(o.tangent), o.width, o.height);

    ReferenceFile file;
    file.image = ReferenceImage(o.width, o.height);
    file.note = note_of(o);
    if (!o.fresh && std::filesystem::exists(o.output)) {
        auto loaded = load_reference(o.output);
        if (!loaded) {
            return fail(loaded.error());
        }
        if (loaded->note != file.note || loaded->image.width != o.width || loaded->image.height != o.height) {
            return fail(
                {"holds another picture: " + loaded->note, o.output, "the same scene, another --output, or --fresh"});
        }
        file = std::move(*loaded);
        std::fprintf(stderr, "%s: going on after %llu samples a pixel\n", o.output.c_str(),
                     static_cast<unsigned long long>(file.image.samples()));
    }
    // This shard's share of the samples: shard, shard + shards, ...
    const std::uint64_t wanted = o.samples / shards + (shard < o.samples % shards ? 1 : 0);
    const PathTracer tracer(std::move(scene));
    const double start = wall_seconds();
    const std::uint64_t before = file.image.samples();
    while (file.image.samples() < wanted) {
        const std::uint64_t done = file.image.samples();
        const std::uint64_t count = std::min(o.every, wanted - done);
        tracer.render(camera, file.image, shard + done * shards, count, shards);
        file.next_sample = shard + file.image.samples() * shards;
        if (Status saved = save_reference(o.output, file); !saved) {
            return fail(saved.error());
        }
        const double took = wall_seconds() - start;
        const auto fresh = static_cast<double>(file.image.samples() - before);
        double noise = 0.0;
        double mean = 0.0;
        for (std::size_t i = 0; i < file.image.squares.size(); ++i) {
            noise += file.image.standard_error(i) * file.image.standard_error(i);
            mean += std::pow(luminance(file.image.mean(i)), 2.0);
        }
        std::fprintf(stderr, "\r%llu of %llu samples a pixel, %.3g paths/s, noise %.2f %%, %.0f s left   ",
                     static_cast<unsigned long long>(file.image.samples()), static_cast<unsigned long long>(wanted),
                     fresh * o.width * o.height / took, 100.0 * std::sqrt(noise / std::max(mean, 1e-30)),
                     took / fresh * static_cast<double>(wanted - file.image.samples()));
    }
    std::fprintf(stderr, "\n");
    return 0;
}

int merge_files(const std::vector<std::string>& inputs, const std::string& output) {
    ReferenceFile sum;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        auto loaded = load_reference(inputs[i]);
        if (!loaded) {
            return fail(loaded.error());
        }
        if (i == 0) {
            sum = std::move(*loaded);
            continue;
        }
        if (loaded->note != sum.note) {
            return fail({"is of another scene: " + loaded->note, inputs[i], sum.note});
        }
        auto merged = merge(sum.image, loaded->image, inputs[i]);
        if (!merged) {
            return fail(merged.error());
        }
        sum.image = std::move(*merged);
        sum.next_sample = std::max(sum.next_sample, loaded->next_sample);
    }
    if (Status saved = save_reference(output, sum); !saved) {
        return fail(saved.error());
    }
    return 0;
}

// A portable float map: linear RGB, from the lowest row up.
int write_pfm(const std::string& input, const std::string& output) {
    const auto file = load_reference(input);
    if (!file) {
        return fail(file.error());
    }
    std::ofstream out(output, std::ios::binary);
    out << "PF\n" << file->image.width << " " << file->image.height << "\n-1.0\n";
    for (int y = file->image.height - 1; y >= 0; --y) {
        for (int x = 0; x < file->image.width; ++x) {
            const glm::vec3 c(file->image.mean(std::size_t(y) * std::size_t(file->image.width) + std::size_t(x)));
            out.write(reinterpret_cast<const char*>(&c), sizeof c);
        }
    }
    return out.flush() ? 0 : fail({"cannot be written", output, "a writable path"});
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app{"Path-traced reference pictures of clouds: unbiased, resumable, in shards. Angles in degrees, azimuth "
                 "from north through east."};
    app.require_subcommand(1);

    RenderOptions o;
    CLI::App* render_command =
        app.add_subcommand("render", "Render, or go on rendering, a picture (or one shard of it)");
    render_command->add_option("-o,--output", o.output, "File of sums to write; an existing one is resumed")
        ->required();
    render_command->add_option("--vdb", o.vdb, "Cloud to render; without it the benchmarks' cumulus");
    render_command->add_option("--grid", o.grid, "Grid in the .vdb file");
    render_command->add_option("--seed", o.seed, "Seed of the benchmarks' cumulus");
    render_command->add_option("--extinction", o.extinction, "1/m at density 1")->check(CLI::PositiveNumber);
    render_command->add_option("--albedo", o.albedo)->check(CLI::Range(0.0, 1.0));
    render_command->add_option("--phase", o.phase)
        ->check(CLI::IsMember({"hg", "double-hg", "cornette-shanks", "rayleigh"}));
    render_command->add_option("--g", o.g)->check(CLI::Range(-1.0, 1.0));
    render_command->add_option("--g2", o.g2, "Second lobe")->check(CLI::Range(-1.0, 1.0));
    render_command->add_option("--weight", o.weight, "Of the first lobe")->check(CLI::Range(0.0, 1.0));
    render_command->add_option("--sun", o.sun, "Azimuth and elevation");
    render_command->add_option("--sun-radius", o.sun_radius, "Of its disc; 0: a point")->check(CLI::Range(0.0, 90.0));
    render_command->add_option("--irradiance", o.irradiance, "Of the sun, RGB");
    render_command->add_flag("--no-sun", o.no_sun);
    render_command->add_option("--sky", o.sky, "Uniform radiance, RGB");
    render_command->add_option("--ground", o.ground, "Albedo of a ground plane, RGB")->each([&](const std::string&) {
        o.with_ground = true;
    });
    render_command->add_option("--ground-height", o.ground_height, "m");
    render_command->add_option("--view", o.view, "Azimuth and elevation that the camera looks from");
    render_command->add_option("--distance", o.distance, "From the cloud's centre, m; 0: 1.7 times its extent");
    render_command->add_option("--tangent", o.tangent, "Of half the vertical field of view")
        ->check(CLI::PositiveNumber);
    render_command->add_option("--width", o.width)->check(CLI::Range(1, 16384));
    render_command->add_option("--height", o.height)->check(CLI::Range(1, 16384));
    render_command->add_option("--samples", o.samples, "A pixel, over all shards");
    render_command->add_option("--every", o.every, "Samples between saves")->check(CLI::PositiveNumber);
    render_command->add_option("--shard", o.shard, "k/n: the k-th of n parts (k from 0)");
    render_command->add_flag("--fresh", o.fresh, "Start over");

    std::vector<std::string> inputs;
    std::string output;
    CLI::App* merge_command = app.add_subcommand("merge", "Add up shards of one picture");
    merge_command->add_option("inputs", inputs)->required();
    merge_command->add_option("-o,--output", output)->required();

    std::string picture;
    CLI::App* pfm_command = app.add_subcommand("pfm", "Write a picture as a portable float map");
    pfm_command->add_option("input", picture)->required();
    pfm_command->add_option("-o,--output", output)->required();

    tool::StudyOptions study;
    CLI::App* study_command =
        app.add_subcommand("study", "Hold the real-time methods to references over media and views");
    study_command->add_option("--references", study.folder, "Folder of references; missing ones are made")->required();
    study_command->add_option("--samples", study.samples, "A pixel, of references");
    study_command->add_option("--cloud", study.cloud, "Seed: below 100 a cumulus, else a noise cloud");
    study_command->add_option("--methods", study.methods)
        ->check(CLI::IsMember({"single", "harris", "octaves", "transport"}));
    study_command->add_option("--albedo", study.albedos);
    study_command->add_option("--g", study.anisotropies);
    study_command->add_option("--transport-factor", study.transport_factor, "Voxels a side of the ordinates' cells")
        ->check(CLI::Range(1, 16));
    study_command->add_option("--sweeps", study.sweeps)->check(CLI::Range(1, 1000));
    study_command->add_flag("--references-only", study.references_only);

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const int code = app.exit(error);
        return code == 0 ? 0 : 2;
    }
    if (render_command->parsed()) {
        return render(o);
    }
    if (merge_command->parsed()) {
        return merge_files(inputs, output);
    }
    if (pfm_command->parsed()) {
        return write_pfm(picture, output);
    }
    const Status done = tool::run_study(study);
    return done ? 0 : fail(done.error());
}
