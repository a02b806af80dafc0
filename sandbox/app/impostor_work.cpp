#include "sandbox/app/impostor_work.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace alpenglow::sandbox {
namespace {

constexpr double kStep = 3000.0; // units, about, that are marched at a time

double texels_of(const impostors::CaptureJob& job) {
    return static_cast<double>(job.texels) * static_cast<double>(job.tiles.size());
}

} // namespace

void CaptureQueue::add(const impostors::CaptureJob& job, std::uint64_t object, const impostors::Sphere& bounds) {
    works_.push_back({job, object, bounds, std::nullopt});
}

void CaptureQueue::drop(impostors::SlotId slot) {
    std::erase_if(works_, [&](const Work& work) { return work.job.slot == slot; });
    captures_.erase(slot);
}

double CaptureQueue::left() const {
    double units = 0.0;
    for (const Work& work : works_) {
        const double texels = work.march ? static_cast<double>(work.march->texels_left()) : texels_of(work.job);
        units += 0.5 * texels + WorkCost::kept_texel * texels_of(work.job) + (work.march ? 0.0 : WorkCost::picture);
    }
    return units;
}

const impostors::Capture* CaptureQueue::find(impostors::SlotId slot) const {
    const auto found = captures_.find(slot);
    return found == captures_.end() ? nullptr : &found->second;
}

double CaptureQueue::work(double units, const Subject& subject, impostors::Scheduler& scheduler,
                          std::vector<impostors::CaptureJob>& done) {
    double spent = 0.0;
    while (!works_.empty() && (spent < units || spent == 0.0)) {
        Work& work = works_.front();
        if (!work.march) {
            const std::optional<CloudSubject> cloud = subject(work.object);
            if (!cloud) {
                scheduler.failed(work.job.slot);
                works_.pop_front();
                continue;
            }
            const std::vector<double> edges =
                impostors::slab_edges(work.bounds, work.job.frustum, static_cast<int>(work.job.tiles.size()));
            work.march.emplace(*cloud, work.job.frustum, edges);
            spent += WorkCost::picture;
            continue;
        }
        const int width = work.job.frustum.width;
        if (!work.march->done()) {
            const auto rows = static_cast<int>(std::clamp(std::min(kStep, units - spent) / width, 4.0, 512.0));
            const std::size_t before = work.march->texels_left();
            const auto seen = static_cast<double>(work.march->march(rows));
            const auto texels = static_cast<double>(before - work.march->texels_left());
            spent += seen * WorkCost::seen_texel + (texels - seen) * WorkCost::empty_texel;
            continue;
        }
        const double keeping = 250.0 + WorkCost::kept_texel * texels_of(work.job);
        if (spent > 0.0 && spent + keeping > 1.15 * units) {
            break; // in the next frame
        }
        spent += keeping;
        impostors::CaptureSettings settings = work.job.settings;
        settings.mips = false; // shown near the size that they are taken at
        const Result<impostors::Capture> made = impostors::capture(
            work.bounds, work.job.frustum, settings,
            [&](const impostors::CaptureRequest& request, std::span<impostors::SlabImage> slabs) -> Status {
                work.march->fill(request, slabs);
                return Ok{};
            });
        if (made) {
            scheduler.measured(work.job.slot, made->sensitivity, made->mean);
            captures_.insert_or_assign(work.job.slot, *made);
            done.push_back(std::move(work.job));
        } else {
            scheduler.failed(work.job.slot);
        }
        works_.pop_front();
    }
    return spent;
}

} // namespace alpenglow::sandbox
