# SPDX-License-Identifier: Apache-2.0
# The web page of the ground station: gse/page, bundled with the packages that gse/page/package-lock.json lists.

ESBUILD := NODE_PATH=build/station/node_modules build/station/node_modules/.bin/esbuild
build/station/page/index.html: build/setup/station $(wildcard gse/page/src/*) gse/page/index.html
	@mkdir -p $(@D)
	@$(ESBUILD) gse/page/src/main.js --bundle --minify --target=es2022 --log-level=warning --loader:.woff2=file \
	    --loader:.woff=empty --asset-names='[name]' --legal-comments=external --outfile=$(@D)/station.js
	@cp gse/page/index.html $@
