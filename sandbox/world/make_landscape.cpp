// make_landscape FILE: generates the landscape and writes it, as a step of the build.
#include "landscape_file.hpp"

#include <cstdio>

int main(int argc, char** argv) {
    using namespace alpenglow;
    if (argc != 2) {
        std::fputs("usage: make_landscape FILE\n", stderr);
        return 2;
    }
    const Status written = sandbox::write_landscape(*sandbox::build_world(), argv[1]);
    if (!written) {
        std::fprintf(stderr, "make_landscape: %s\n", written.error().message().c_str());
        return 1;
    }
    return 0;
}
