# SPDX-License-Identifier: GPL-2.0-or-later
# What `cmake --install` puts where, and the Debian package of `make deb`. See doc/installation.md.
include(GNUInstallDirs)

set(MPDEM_LEVELS "" CACHE STRING
    "Instruction sets of a program for other machines, the oldest first, e.g. x86-64-v3;x86-64-v4; empty: the program has that of MPDEM_ARCH")
set(MPDEM_MANUAL ${CMAKE_BINARY_DIR}/manual CACHE PATH "Folder of the HTML manual, installed if it is there")
set(MPDEM_MAINTAINER "The USER-MPDEM developers" CACHE STRING "Maintainer of the Debian package: name <address>")
set(MPDEM_PYTHON_DIR "" CACHE STRING "Folder of Python packages below the prefix; empty: that in which Debian's Python looks")

set(SHARE ${CMAKE_INSTALL_DATAROOTDIR}/liggghts-mpdem)
set(DOCUMENTS ${CMAKE_INSTALL_DATAROOTDIR}/doc/liggghts-mpdem)
set(PRIVATE_LIBRARIES ${CMAKE_INSTALL_LIBDIR}/liggghts-mpdem)

# A program for several instruction sets. All of it but the start is the library libmpdem.so, compiled once for each of them. The loader
# of glibc takes the newest that the processor has from the folders glibc-hwcaps. The library is the first that the program needs, so its
# definitions take precedence over those of LIGGGHTS, as those of the executable do (host/registration.cpp). A boundary between
# kernels and the rest would not do: the layout of Eigen's types and how vectors of eight lanes are passed depend on the instruction set.
if(MPDEM_LEVELS)
  include(CheckLinkerFlag)
  get_target_property(FILES_OF_CORE mpdem_core SOURCES)
  get_target_property(FILES_OF_PROGRAM liggghts-mpdem SOURCES)
  set_target_properties(mpdem_core liggghts-mpdem PROPERTIES EXCLUDE_FROM_ALL ON)
  set(OPTIONS_WITHOUT_ARCH ${KERNEL_OPTIONS})
  list(FILTER OPTIONS_WITHOUT_ARCH EXCLUDE REGEX "^-march=")

  # main() is in the library.
  file(WRITE ${CMAKE_BINARY_DIR}/empty.cpp "")
  add_executable(program_of_levels ${CMAKE_BINARY_DIR}/empty.cpp)
  file(RELATIVE_PATH TO_LIBRARIES /${CMAKE_INSTALL_BINDIR} /${PRIVATE_LIBRARIES})
  set_target_properties(program_of_levels PROPERTIES OUTPUT_NAME liggghts-mpdem RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/levels
    INSTALL_RPATH "$ORIGIN/${TO_LIBRARIES}")
  install(TARGETS program_of_levels RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

  list(GET MPDEM_LEVELS 0 OLDEST)
  foreach(LEVEL ${MPDEM_LEVELS})
    set(LIBRARY mpdem_${LEVEL})
    set(SUBFOLDER /glibc-hwcaps/${LEVEL})
    if(LEVEL STREQUAL OLDEST)
      set(SUBFOLDER "")
    endif()
    add_library(${LIBRARY} SHARED ${FILES_OF_CORE} ${FILES_OF_PROGRAM})
    target_include_directories(${LIBRARY} PRIVATE ${PACKAGE_DIR})
    target_include_directories(${LIBRARY} SYSTEM PRIVATE ${LIGGGHTS_INCLUDE})
    target_compile_definitions(${LIBRARY} PRIVATE OMPI_SKIP_MPICXX)
    # Calls within the library are direct, as in an executable.
    target_compile_options(${LIBRARY} PRIVATE ${OPTIONS_WITHOUT_ARCH} -march=${LEVEL} -fno-semantic-interposition)
    target_link_options(${LIBRARY} PRIVATE -Wl,-Bsymbolic-functions)
    check_linker_flag(CXX -Wl,-z,${LEVEL} LINKER_MARKS_${LEVEL})
    if(LINKER_MARKS_${LEVEL})
      target_link_options(${LIBRARY} PRIVATE -Wl,-z,${LEVEL})  # the loader refuses it on an older processor
    endif()
    target_link_libraries(${LIBRARY} PRIVATE Eigen3::Eigen MPI::MPI_CXX ${LIGGGHTS_LIBRARY} ${CMAKE_DL_LIBS})
    target_precompile_headers(${LIBRARY} PRIVATE ${MPDEM_COMMON_HEADERS})
    set_target_properties(${LIBRARY} PROPERTIES OUTPUT_NAME mpdem LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/levels${SUBFOLDER})
    if(MPDEM_UNITY)
      set_target_properties(${LIBRARY} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    endif()
    install(TARGETS ${LIBRARY} LIBRARY DESTINATION ${PRIVATE_LIBRARIES}${SUBFOLDER})
    if(LEVEL STREQUAL OLDEST)
      target_link_libraries(program_of_levels PRIVATE ${LIBRARY})
    else()
      add_dependencies(program_of_levels ${LIBRARY})
    endif()
  endforeach()
else()
  install(TARGETS liggghts-mpdem RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

# The version with what follows its numbers, such as -dev. In a version of Debian a ~ comes before the release.
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" FULL_VERSION "${MPDEM_VERSION}")
string(REPLACE "-" "~" DEBIAN_VERSION "${FULL_VERSION}")

# The page of `man` and the changelog, compressed as Debian wants them: without the time, so that each build gives the same bytes.
function(install_compressed file name folder)
  execute_process(COMMAND gzip -9nc ${file} OUTPUT_FILE ${CMAKE_BINARY_DIR}/${name}.gz RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "gzip cannot compress ${file}; install gzip")
  endif()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  install(FILES ${CMAKE_BINARY_DIR}/${name}.gz DESTINATION ${folder})
endfunction()
set(PROCESSOR_NOTE "The program was compiled for \\-march=${MPDEM_ARCH}. On a processor without these instructions it ends by SIGILL.")
if(MPDEM_LEVELS)
  string(REPLACE ";" ", " PROCESSOR_NOTE "${MPDEM_LEVELS}")
  set(PROCESSOR_NOTE "The program has code for these instruction sets: ${PROCESSOR_NOTE}. The loader takes the newest that the processor has. On an older \
processor it ends with the message \\(lqCPU ISA level is lower than required\\(rq; compile the program there.")
endif()
configure_file(packaging/liggghts-mpdem.1.in liggghts-mpdem.1 @ONLY)
install_compressed(${CMAKE_BINARY_DIR}/liggghts-mpdem.1 liggghts-mpdem.1 ${CMAKE_INSTALL_MANDIR}/man1)
install_compressed(${CMAKE_SOURCE_DIR}/CHANGELOG.md changelog ${DOCUMENTS})
install(FILES packaging/copyright README.md CITATION.cff DESTINATION ${DOCUMENTS})
install(DIRECTORY ${MPDEM_MANUAL}/ DESTINATION ${DOCUMENTS}/html OPTIONAL PATTERN .doctrees EXCLUDE PATTERN .buildinfo EXCLUDE)

# Examples, and the tools that need no source. They find each other as in the repository: SHARE has its layout.
set(COMMANDS mpdem_plot mpdem_movie mpdem_picture pair_table specimen parameters)
install(DIRECTORY examples DESTINATION ${SHARE} USE_SOURCE_PERMISSIONS)
install(DIRECTORY tools/mpdem DESTINATION ${SHARE}/tools PATTERN __pycache__ EXCLUDE)
foreach(TOOL ${COMMANDS} content_picture flawed_pairs gallery paraview_picture vtk_picture)
  install(PROGRAMS tools/${TOOL}.py DESTINATION ${SHARE}/tools)
endforeach()

# Installs a link that leads from one place below the prefix to another.
function(install_link from to)
  get_filename_component(folder ${from} DIRECTORY)
  get_filename_component(name ${from} NAME)
  file(RELATIVE_PATH target /${folder} /${to})
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/links)
  file(CREATE_LINK ${target} ${CMAKE_BINARY_DIR}/links/${name} SYMBOLIC)
  install(FILES ${CMAKE_BINARY_DIR}/links/${name} DESTINATION ${folder})
endfunction()
# tools/mpdem_plot.py is the command mpdem-plot, tools/specimen.py is mpdem-specimen.
foreach(TOOL ${COMMANDS})
  string(REGEX REPLACE "^mpdem_" "" NAME ${TOOL})
  string(REPLACE "_" "-" NAME ${NAME})
  install_link(${CMAKE_INSTALL_BINDIR}/mpdem-${NAME} ${SHARE}/tools/${TOOL}.py)
endforeach()
# So that `import mpdem` finds the package.
set(PYTHON_FOLDER ${MPDEM_PYTHON_DIR})
if(NOT PYTHON_FOLDER AND CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(PYTHON_FOLDER lib/python3/dist-packages)
elseif(NOT PYTHON_FOLDER)
  execute_process(COMMAND /usr/bin/python3 -c "import sys; print('lib/python3.%d/dist-packages' % sys.version_info[1])"
    OUTPUT_VARIABLE PYTHON_FOLDER OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT PYTHON_FOLDER)
    message(FATAL_ERROR "/usr/bin/python3 does not run; name the folder of Python packages, below the prefix, with -DMPDEM_PYTHON_DIR=...")
  endif()
endif()
install_link(${PYTHON_FOLDER}/mpdem ${SHARE}/tools/mpdem)

# A Debian package is for other machines, so it needs MPDEM_LEVELS. The program relies on the layout of LIGGGHTS' classes and on its symbols:
# the package depends on the very version of the library that it was compiled with.
if(MPDEM_LEVELS AND CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  get_filename_component(LIGGGHTS_FILE ${LIGGGHTS_LIBRARY} REALPATH)
  execute_process(COMMAND dpkg-query -S ${LIGGGHTS_FILE} OUTPUT_VARIABLE OWNER_OF_LIBRARY ERROR_QUIET)
  if(OWNER_OF_LIBRARY MATCHES "^([a-z0-9.+-]+)(:[a-z0-9]+)?: ")
    set(HOST_PACKAGE ${CMAKE_MATCH_1})
    execute_process(COMMAND dpkg-query -W -f \${Version} ${HOST_PACKAGE} OUTPUT_VARIABLE HOST_VERSION)
  else()
    message(FATAL_ERROR "${LIGGGHTS_FILE} is of no Debian package, so what a package depends on is not known; install libliggghts-dev")
  endif()
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_NAME liggghts-mpdem)
  set(CPACK_PACKAGE_CONTACT "${MPDEM_MAINTAINER}")
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_VERSION ${DEBIAN_VERSION})
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PACKAGE_DEPENDS
      "${HOST_PACKAGE} (= ${HOST_VERSION}), mpi-default-bin, python3, python3-numpy, python3-pandas, python3-matplotlib")
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-pil, python3-vtk9")
  set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg, xvfb, xauth, paraview")
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/levels)
  set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "LIGGGHTS with cement of material points between grains
Discrete elements of LIGGGHTS for the grains of cemented soils, and for the
cement of each bond a continuum of material points with anisotropic elasticity
and damage. Stiffness, strength and mode of failure of a bond are results of
the geometry of the cement, its moduli, strength and fracture energy.

This package has the program, examples, tools for pictures and tables, the
Python package mpdem and the manual. The processor needs ${OLDEST} or newer.")
  include(CPack)
endif()
