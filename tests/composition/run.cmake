# Configures and builds the sandbox with sets of modules, and has each build render a frame. All share the compiler's
# cache where there is one, and one folder of objects a set, so that a second run builds only what has changed.
find_program(CCACHE ccache)
if(NOT LAUNCHER AND CCACHE)
    set(LAUNCHER "${CCACHE}")
endif()
set(base "ecs;sh;ephemeris;sky")
if(SETS)
    set(chosen "${SETS}")
else()
    set(chosen sky ephemeris without-clouds without-prt all)
endif()
set(list_of_sky "ecs;sh;sky") # the sky is made of spherical harmonics; its sun stands still
set(list_of_ephemeris "${base}")
set(list_of_without-clouds "${base};prt;probes;impostors")
set(list_of_without-prt "${base};probes;clouds;impostors")
set(list_of_all "${base};prt;probes;clouds;impostors")
foreach(name IN LISTS chosen)
    set(build "${WORK}/${name}")
    message(STATUS "${name}: ${list_of_${name}}")
    # A build configures itself anew where it must.
    if(NOT EXISTS "${build}/CMakeCache.txt" OR "${CMAKE_CURRENT_LIST_FILE}" IS_NEWER_THAN "${build}/CMakeCache.txt")
        execute_process(
            COMMAND "${CMAKE_COMMAND}" -S "${SOURCE}" -B "${build}" -G "${GENERATOR}" -DCMAKE_BUILD_TYPE=Release
                    "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}"
                    "-DALPENGLOW_MODULES=${list_of_${name}}" -DALPENGLOW_ASSERTIONS=ON -DALPENGLOW_WARNINGS_AS_ERRORS=ON
                    -DALPENGLOW_BUILD_TESTS=OFF -DALPENGLOW_BUILD_BENCHMARKS=OFF -DALPENGLOW_BUILD_TOOLS=OFF
                    -DALPENGLOW_INSTALL=OFF
            OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
        file(TOUCH "${build}/CMakeCache.txt")
    endif()
    # The landscape takes longer than the rest: the one of the surrounding build serves.
    if(EXISTS "${LANDSCAPE}")
        execute_process(COMMAND "${CMAKE_COMMAND}" --build "${build}" --target make_landscape --parallel 2 OUTPUT_QUIET
                        COMMAND_ERROR_IS_FATAL ANY)
        file(MAKE_DIRECTORY "${build}/sandbox")
        file(COPY_FILE "${LANDSCAPE}" "${build}/sandbox/landscape.bin" ONLY_IF_DIFFERENT)
        file(TOUCH "${build}/sandbox/landscape.bin")
    endif()
    execute_process(COMMAND "${CMAKE_COMMAND}" --build "${build}" --target alpenglow-sandbox --parallel 2
                    OUTPUT_VARIABLE log ERROR_VARIABLE log RESULT_VARIABLE failed)
    if(failed)
        message(FATAL_ERROR "${name} does not build:\n${log}")
    endif()
    set(program "${build}/sandbox/alpenglow-sandbox")
    foreach(scene valley-afternoon squadron)
        set(picture "${build}/${scene}.png")
        if(EXISTS "${picture}" AND "${picture}" IS_NEWER_THAN "${program}"
           AND NOT "${SOURCE}/sandbox/scenes/${scene}.json" IS_NEWER_THAN "${picture}")
            continue() # this program has drawn it already
        endif()
        file(REMOVE "${picture}")
        execute_process(COMMAND "${program}" --headless --size 160x90 --frames 2 --scene ${scene} --out "${picture}"
                        OUTPUT_VARIABLE log ERROR_VARIABLE log RESULT_VARIABLE failed)
        if(failed OR NOT EXISTS "${picture}")
            message(FATAL_ERROR "${name} does not run ${scene}:\n${log}")
        endif()
        message(STATUS "${name}: ${scene}: ${log}")
    endforeach()
endforeach()
