// Path-traces a scene's clouds from where the scene begins: make_cloud_reference SCENE SAMPLES OUT
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <span>
#include <string>

#include "sandbox/app/cloud_reference.hpp"
#include "sandbox/app/cloud_scene.hpp"
#include "sandbox/app/game.hpp"
#include "sandbox/world/landscape_file.hpp"

int main(int count, char** arguments) {
    using namespace alpenglow;
    using namespace alpenglow::sandbox;
    if (count != 4) {
        std::cerr << "make_cloud_reference SCENE SAMPLES OUT\n";
        return 2;
    }
    const Result<Scene> scene = load_scene(arguments[1]);
    if (!scene || !scene->clouds || scene->clouds->layers.size() != 1) {
        std::cerr << (scene ? "the scene has no single layer of clouds" : scene.error().message()) << '\n';
        return 2;
    }
    const std::filesystem::path file = built_landscape();
    Game game(*scene, open_world(std::span(&file, 1)).world);
    game.update(0.0, 64, 36);
    const clouds::CloudSources sources = game.part<CloudScene>()->sources();
    const clouds::SparseGrid grid = layer_grid(*scene->clouds, scene->clouds->layers.front());
    const clouds::PathTracer tracer(reference_scene(grid, scene->clouds->layers.front().matter, sources));
    const clouds::Camera camera = reference_camera(scene_camera(*scene));
    clouds::ReferenceFile out;
    out.image = clouds::ReferenceImage(camera.width, camera.height);
    out.note = reference_note(sources);
    out.next_sample = static_cast<std::uint64_t>(std::atoll(arguments[2]));
    tracer.render(camera, out.image, 0, out.next_sample);
    const Status saved = clouds::save_reference(arguments[3], out);
    if (!saved) {
        std::cerr << saved.error().message() << '\n';
        return 1;
    }
    return 0;
}
