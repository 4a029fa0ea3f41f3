#!/usr/bin/env python3
"""Checks what is in deploy/ without a cluster: schemas of Kubernetes and of Compose, and what no schema says.

    python3 scripts/deployments.py

Needs the Python packages `kubernetes-validate`, `check-jsonschema` and `pyyaml`, which bring the schemas; those of KEDA and
Kustomize are not among them.
"""
import glob, os, subprocess, sys
import kubernetes_validate, yaml

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')
WITHOUT_SCHEMA = {'ScaledObject', 'TriggerAuthentication', 'Kustomization'}


def containers(document):
    """The containers of a workload."""
    return document.get('spec', {}).get('template', {}).get('spec', {}).get('containers', [])


def faults(document, known):
    """What is wrong with an object of Kubernetes, `known` being the names of all objects by kind."""
    if document['kind'] not in WITHOUT_SCHEMA:
        try: kubernetes_validate.validate(document, kubernetes_validate.latest_version(), strict=True)
        except kubernetes_validate.ValidationError as error: yield f"{'.'.join(map(str, error.path))}: {error.message}"
    for container in containers(document):
        if 'memory' not in container.get('resources', {}).get('limits', {}): yield f"container {container['name']} has no limit of memory"
        if not container.get('securityContext', {}).get('readOnlyRootFilesystem'): yield f"container {container['name']} may write to its root"
        if any('containerPort' in port for port in container.get('ports', [])):
            for probe in ('startupProbe', 'livenessProbe', 'readinessProbe'):
                if probe not in container: yield f"container {container['name']} has no {probe}"
    if document['kind'] == 'ScaledObject' and document['spec']['scaleTargetRef']['name'] not in known['Deployment']:
        yield 'it scales what is not there'
    if document['kind'] == 'ScaledObject':
        for trigger in document['spec']['triggers']:
            if trigger['authenticationRef']['name'] not in known['TriggerAuthentication']: yield 'its authentication is not there'
    if document['kind'] == 'Ingress':
        for rule in document['spec']['rules']:
            for path in rule['http']['paths']:
                if path['backend']['service']['name'] not in known['Service']: yield 'its service is not there'
    if document['kind'] == 'Kustomization':
        files = {os.path.basename(file) for file in glob.glob(os.path.join(ROOT, 'deploy/kubernetes/*.yaml'))}
        if set(document['resources']) != files - {'kustomization.yaml'}: yield 'it does not name all files'


def main():
    documents = [(os.path.relpath(file, ROOT), document) for file in sorted(glob.glob(os.path.join(ROOT, 'deploy/kubernetes/*.yaml')))
                 for document in yaml.safe_load_all(open(file))]
    known = {}
    for _, document in documents: known.setdefault(document['kind'], set()).add(document.get('metadata', {}).get('name'))
    found = [f"{file}: {document['kind']} {document.get('metadata', {}).get('name', '')}: {fault}"
             for file, document in documents for fault in faults(document, known)]
    for fault in found: print(fault)
    compose = subprocess.run(['check-jsonschema', '--builtin-schema', 'vendor.compose-spec', os.path.join(ROOT, 'deploy/compose.yaml')])
    print(f'{len(documents)} objects of Kubernetes, {len(found)} faults')
    sys.exit(bool(found) or compose.returncode)


if __name__ == '__main__': main()
